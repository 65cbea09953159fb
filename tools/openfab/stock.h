// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets that come with openfab, and what else it writes into folders that it makes.

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::tool {

/// By its file's name; there must be one.
std::string_view stock_text(std::string_view name);

/// A stock fablet's file is stock_NAME.fl; the fablet in it has the name with a capital.
constexpr std::array<const char*, 8> kStockFablets = {"solid",  "textured", "mapped",  "painted",
                                                      "graded", "shell",    "lattice", "relief"};

bool is_stock_fablet(std::string_view name);

/// "`solid`, `textured`, …", for messages.
std::string stock_fablet_names();

/// The file of a stock fablet as it is, in `folder`, to be compiled.
Result<std::filesystem::path> stock_source(const std::string& fablet,
                                           const std::filesystem::path& folder);

/// Writes a file, and the folders that it is in. Errors: the disk's.
Result<void> write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace openfab::tool
