// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stock fablets of openfab, and other files that it writes to new folders.

#include <filesystem>
#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::tools {

/// Returns the text by its file name, which must exist.
std::string_view stock_text(std::string_view name);

/// A stock fablet and what `openfab import` must know of it: its file is stock_NAME.fl, its fablet
/// has the capitalised name, and tools/openfab/import.cpp has a function that binds its uniforms.
struct StockFablet {
    std::string_view name;
    bool inks = false;     ///< mixes cyan, magenta, yellow, black and white
    bool uv = false;       ///< needs texture coordinates
    bool picture = false;  ///< needs a picture
    bool colors = false;   ///< needs colours of vertices or faces
};
inline constexpr StockFablet kStockFablets[] = {
    {"solid"},
    {"mixed"},
    {.name = "textured", .inks = true, .uv = true, .picture = true},
    {.name = "mapped", .inks = true, .picture = true},
    {.name = "painted", .inks = true, .colors = true},
    {"graded"},
    {"shell"},
    {"lattice"},
    {"infill"},
    {.name = "relief", .uv = true, .picture = true},
};
/// Returns the row of that name, or null.
const StockFablet* find_stock_fablet(std::string_view name);

/// Changes `const int NAME = 1;` in the source of a stock fablet, where it has that, and gives lists
/// of NAME values as many of their defaults.
void set_stock_constant(const std::string& name, size_t value, std::string* source);

/// Replaces the formula by which a stock fablet mixes inks by the look-up of a table.
void mix_by_profile(std::string* source);

/// Returns "`solid`, `textured`, …", for messages.
std::string stock_fablet_names();

/// Writes the unchanged file of a stock fablet to `folder` and returns its path.
Result<std::filesystem::path> stock_source(const std::string& fablet,
                                           const std::filesystem::path& folder);

/// Writes a file and creates its folders.
Result<void> write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace openfab::tools
