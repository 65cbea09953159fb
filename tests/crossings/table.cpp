// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/table.h"

#include <fmt/format.h>

#include <algorithm>

#include "tests/support/says/says.h"

namespace openfab::testing {

namespace {

bool is(std::string_view name, std::string_view patterns) {
    const size_t bar = patterns.find('|');
    const std::string_view pattern = patterns.substr(0, bar);
    const bool fits = pattern.ends_with('*')
                          ? name.starts_with(pattern.substr(0, pattern.size() - 1))
                          : name == pattern;
    return fits || (bar != std::string_view::npos && is(name, patterns.substr(bar + 1)));
}

Made make(const Column& column, const Kind& kind, Form form) {
    const Bench bench(kind, form, column.change);
    return column.make != nullptr ? column.make(bench) : bench.print_here();
}

}  // namespace

bool Cells::have(const Column& of_column, const Kind& of_kind, Form of_form) const {
    return is(of_column.id, column) && is(of_kind.id, kind) && is(name_of(of_form), form);
}

const Known* find(std::span<const Known> rows, const Column& column, const Kind& kind, Form form) {
    for (const Known& row : rows) {
        if (row.cells.have(column, kind, form)) return &row;
    }
    return nullptr;
}

Cell try_cell(const Column& column, const Kind& kind, Form form, Twins* twins) {
    const Kind& twin = twin_of(kind);
    const std::string key = fmt::format("{}/{}/{}", kind.id == "primitive", twin.id, name_of(form));
    if (twins->count(key) == 0) (*twins)[key] = make(column, twin, form);
    Cell cell = compare(make(column, kind, form), twins->at(key));
    const auto named = std::find_if(refusals().begin(), refusals().end(), [&](const Refusal& row) {
        return row.cells.have(column, kind, form) &&
               (cell.verdict != Verdict::kRefused ||
                (says(cell.why, row.message) && (row.help.empty() || says(cell.why, row.help))));
    });
    if (cell.verdict == Verdict::kRefused && named == refusals().end())
        return {Verdict::kWrong, "refused by what no row of refusals.cpp names: " + cell.why};
    if (cell.verdict != Verdict::kRefused && named != refusals().end())
        return {Verdict::kWrong, "not refused, as refusals.cpp has it; " + cell.why};
    // It is printed all the same.
    if (cell.verdict == Verdict::kWrong && find(documented(), column, kind, form) != nullptr &&
        cell.ends_alike)
        cell.verdict = Verdict::kDocumented;
    return cell;
}

char symbol_of(Verdict verdict) {
    switch (verdict) {
        case Verdict::kEqual:
            return '=';
        case Verdict::kBounded:
            return '~';
        case Verdict::kRefused:
            return 'r';
        case Verdict::kDocumented:
            return 'd';
        case Verdict::kWrong:
            return '!';
    }
    return '!';
}

}  // namespace openfab::testing
