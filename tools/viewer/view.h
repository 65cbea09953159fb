// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab view`: prints, or a world that is printed again and again, in a page for a browser.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::viewer {

struct ViewOptions {
    std::string file;     ///< an .ofr file, finished or not, or a world (.fab.json)
    std::string compare;  ///< a second print; empty: none
    std::string world;    ///< or the mesh that the print was made from; empty: unknown
    std::string fablet;   ///< of a print of a mesh, as of `openfab print`; empty: of a world
    std::string address = "127.0.0.1";
    int32_t port = 0;    ///< 0: any that is free
    bool watch = false;  ///< print a world again on each change, and let the page make changes
    std::vector<std::string>
        templates;      ///< of a world that this command made: others that the page offers
    int32_t draft = 0;  ///< a world's pitch times this; 0: as the part needs
    std::vector<std::string> allow;     ///< folders that a world may read besides its own
    std::vector<std::string> settings;  ///< OBJECT.UNIFORM=VALUE, as of a print
    std::string words;                  ///< said after the address
    int64_t memory_bytes = 0;
    std::filesystem::path programs;  ///< the folder of openfab and openflc
};

/// Serves until the process is ended; returns only on an error.
Result<void> view(const ViewOptions& options);

}  // namespace openfab::viewer
