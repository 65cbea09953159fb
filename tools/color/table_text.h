// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The words of tables of patches: CGATS text and CSV.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::color {

/// The most columns of a table.
constexpr int kMostColumns = 1000;

/// Returns whether a table is CGATS text, whatever its head holds: only that has the keyword
/// BEGIN_DATA_FORMAT, alone on a line. Any other table begins with the names of its columns.
bool is_cgats(std::string_view text);

/// Removes and returns the next word, or none: of what stands between blanks or commas, or in quotes,
/// where it may be empty. From `#` on the line is a comment.
std::optional<std::string_view> take(std::string_view* line);
/// Same; an empty word where there is none.
std::string_view take_word(std::string_view* line);

/// Returns the cells of a line of a CSV; two separators with nothing between them are an empty one.
std::vector<std::string_view> cells_of(std::string_view line, char separator);

/// Returns ASCII letters as capitals.
std::string upper(std::string_view text);

}  // namespace openfab::color
