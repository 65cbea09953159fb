// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/browser.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>

#include "base/own_folder.h"
#include "base/say.h"
#include "client/child.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

bool is_set(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
}

/// The program that opens addresses; empty if there is none.
fs::path opener() {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        const fs::path program = fs::path(folder) / "xdg-open";
        if (fs::path(folder).is_absolute() && ::access(program.c_str(), X_OK) == 0) return program;
    }
    return {};
}

}  // namespace

void open_in_browser(const std::string& url) {
    if (::isatty(STDOUT_FILENO) == 0) return;
    const fs::path program = is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") ? opener() : fs::path();
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!program.empty() && folder) {
        const Result<std::unique_ptr<client::Child>> child =
            client::Child::start({program.string(), url}, (*folder)->path() / "browser.out",
                                 (*folder)->path() / "browser.err");
        // It hands the address over, and ends.
        if (child && (*child)->wait() == 0) return;
    }
    note(messages::kOpenTheAddress);
}

}  // namespace openfab::viewer
