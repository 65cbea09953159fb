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
constexpr std::array<const char*, 10> kStockFablets = {"solid",   "mixed",  "textured", "mapped",
                                                       "painted", "graded", "shell",    "lattice",
                                                       "infill",  "relief"};

/// Changes `const int NAME = 1;` in the source of a stock fablet, where it has that, and gives lists
/// of NAME values as many of their defaults.
void set_stock_constant(const std::string& name, size_t value, std::string* source);

/// Replaces the formula by which a stock fablet mixes inks by the look-up of a table.
void mix_by_profile(std::string* source);

bool is_stock_fablet(std::string_view name);

/// Returns "`solid`, `textured`, …", for messages.
std::string stock_fablet_names();

/// Writes the unchanged file of a stock fablet to `folder` and returns its path.
Result<std::filesystem::path> stock_source(const std::string& fablet,
                                           const std::filesystem::path& folder);

/// Writes a file and creates its folders.
Result<void> write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace openfab::tools
