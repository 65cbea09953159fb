// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stock fablets of openfab, and other files that it writes to new folders.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::tools {

/// Returns the text by its file name, which must exist.
std::string_view stock_text(std::string_view name);

/// A stock fablet's file is stock_NAME.fl; its fablet has the capitalised name.
constexpr std::array<const char*, 9> kStockFablets = {
    "solid", "textured", "mapped", "painted", "graded", "shell", "lattice", "infill", "relief"};

bool is_stock_fablet(std::string_view name);

/// Returns "`solid`, `textured`, …", for messages.
std::string stock_fablet_names();

/// Writes the unchanged file of a stock fablet to `folder` and returns its path.
Result<std::filesystem::path> stock_source(const std::string& fablet,
                                           const std::filesystem::path& folder);

/// Writes a file and creates its folders.
Result<void> write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace openfab::tools
