// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the commands say when something is wrong.

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "base/say.h"
#include "base/text.h"
#include "compiler/diag/render.h"
#include "compiler/driver/commands.h"

namespace openfab::driver {

void print_diagnostics(const diag::Sink& sink, const source::SourceManager& sources,
                       const CommonOptions& common) {
    say(common.json_diagnostics ? printable_json(diag::render_json(sink, sources))
                                : diag::render_text(sink, sources));
}

int fail(const std::string& what, int code) {
    say(fmt::format("openflc: {}: {}\n", code == kExitBug ? "internal error" : "error", what));
    return code;
}

int unread_exit_code(const std::filesystem::path& file) {
    std::error_code unknown;
    const bool folder = std::filesystem::is_directory(file, unknown);
    const uintmax_t size = folder ? 0 : std::filesystem::file_size(file, unknown);
    const bool large = !unknown && size > source::SourceManager::kMaxFileBytes;
    return folder || large ? kExitUserInput : kExitOutside;
}

}  // namespace openfab::driver
