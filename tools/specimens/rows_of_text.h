// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables in text as machines and spreadsheets write them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::specimens {

struct TextRow {
    int32_t line = 0;
    std::vector<std::string> cells;  ///< without quotes, and without blanks around them
};

struct TextTable {
    std::vector<TextRow> rows;  ///< without empty lines
    bool decimal_comma = false;
};

/// Splits at tabs, else semicolons, else commas: the first that some line has. Commas between digits are decimal ones
/// where they do not separate cells.
TextTable read_text_table(std::string_view text);
/// Reads a cell as a number; false for what is none.
bool read_cell(const TextTable& table, const std::string& cell, double* out);
/// Quotes a cell where it needs that.
std::string csv_cell(const std::string& text);

}  // namespace openfab::specimens
