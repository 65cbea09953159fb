// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The table: what each cell is expected to be, and its page.

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tests/crossings/columns.h"

namespace openfab::testing {

/// Some cells: ids and names, `|` between several, `*` at an end for all that begin so.
struct Cells {
    std::string_view column, kind, form;
    bool have(const Column& column, const Kind& kind, Form form) const;
};

/// Cells that are refused, and by which message; it gives a way out, or `help` does.
struct Refusal {
    Cells cells;
    std::string_view message, help;
};
std::span<const Refusal> refusals();

/// Cells that are not as their twin, as documents say, or that are wrong; none of those is, in the end.
struct Known {
    Cells cells;
    std::string_view why;
};
std::span<const Known> documented();
std::span<const Known> known_wrong();

/// Returns the first row that has a cell, or null.
const Known* find(std::span<const Known> rows, const Column& column, const Kind& kind, Form form);

/// Tries a cell; a refusal that no row of `refusals` names is wrong. `twins` keeps what the column makes of twins.
using Twins = std::map<std::string, Made>;
Cell try_cell(const Column& column, const Kind& kind, Form form, Twins* twins);

/// A character for each verdict: `=`, `~`, `r`, `d`, `!`.
char symbol_of(Verdict verdict);

/// The lines of the page's table, by column; a line has the symbols of all forms of each kind.
using Lines = std::map<std::string, std::string>;
/// Where a cell is in its line.
size_t place_of(size_t kind, Form form);
Lines read_page(std::string_view page);
std::string page_of(const Lines& lines);

}  // namespace openfab::testing
