// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "tests/crossings/table.h"

namespace openfab::testing {

namespace {

constexpr size_t kFormCount = std::size(kForms);
constexpr size_t kNameWidth = 17;

std::string letter_of(size_t kind) {
    return std::string(1, static_cast<char>('A' + kind));
}

}  // namespace

size_t place_of(size_t kind, Form form) {
    return kNameWidth + kind * (kFormCount + 1) + static_cast<size_t>(form);
}

Lines read_page(std::string_view page) {
    Lines out;
    std::istringstream text{std::string(page)};
    for (std::string line; std::getline(text, line);) {
        for (const Column& column : columns()) {
            if (line.starts_with(column.id + std::string(kNameWidth - column.id.size(), ' ')) &&
                line.size() == place_of(kinds().size(), Form::kWhole) - 1)
                out[column.id] = line;
        }
    }
    return out;
}

std::string page_of(const Lines& lines) {
    std::array<int64_t, 256> counts{};
    int64_t cells = 0;
    for (const auto& [id, line] : lines) {
        for (size_t k = 0; k < kinds().size(); ++k) {
            for (const Form form : kForms) {
                ++counts[static_cast<unsigned char>(line[place_of(k, form)])];
                ++cells;
            }
        }
    }
    std::string out = fmt::format(
        R"(# Every kind of geometry, with every feature and tool
What holds for one kind of geometry holds for all, or is refused with a message that says what to do instead. A test,
`crossings_test`, prints one small solid, the hull of two balls with a skin and two inner materials, as each kind of
geometry has it, with each feature and tool, and compares the result with that of a twin: a mesh of the same solid under
the same feature. It makes this page (`OPENFAB_LONG=1 OPENFAB_UPDATE=1`); a part of it is tried on each push, all of it
in nightly runs. From Python, each kind in each form prints the same array as from the command line
(`tests/python/test_kinds.py`); words of the product that have no line here are in `tests/crossings/elsewhere.cpp`, each
with its reason.

| cells | | |
| --- | --- | --- |
| {} | `=` | the same voxels, or numbers, as the twin |
| {} | `~` | the same within a bound: at most {:.0f} of 100 voxels next to another material differ, and a tenth of that in mixtures; numbers by at most {:.0f} % |
| {} | `r` | refused with a message that gives a way out |
| {} | `d` | otherwise, as documents say |
| {} | `!` | known to be wrong |
| {} | | in all: {} of {} features and tools, {} kinds, each in {} forms |

The facets of the twin, up to {} of a voxel inside the solid, are why most curved solids are `~`.

)",
        counts['='], counts['~'], 100 * kShare, 100 * kNumbers, counts['r'], counts['d'],
        counts['!'], cells, lines.size(), columns().size(), kinds().size(), kFormCount, 0.004);
    out += "Kinds:\n\n| | |\n| --- | --- |\n";
    for (size_t k = 0; k < kinds().size(); ++k)
        out += fmt::format("| {} | {} |\n", letter_of(k), kinds()[k].what);
    out += "\nThe four characters of a cell are the forms of a build: ";
    for (const Form form : kForms)
        out += fmt::format("{}{}", form == Form::kWhole ? "" : ", ", name_of(form));
    out += ".\n\n```text\n" + std::string(kNameWidth, ' ');
    std::string head;
    for (size_t k = 0; k < kinds().size(); ++k)
        head += fmt::format("{:<{}}", letter_of(k), kFormCount + 1);
    out += head.substr(0, head.find_last_not_of(' ') + 1) + "\n";
    for (const Column& column : columns()) {
        if (lines.count(column.id) != 0) out += lines.at(column.id) + "\n";
    }
    std::string missing;
    for (const Column& column : columns()) {
        if (lines.count(column.id) == 0) missing += (missing.empty() ? "" : ", ") + column.id;
    }
    out += "```\n";
    if (!missing.empty()) out += "\nNot tried in full yet: " + missing + ".\n";
    out += "\nThe lines:\n\n| | |\n| --- | --- |\n";
    for (const Column& column : columns())
        out += fmt::format("| {} | {} |\n", column.id, column.what);
    out += "\nDocumented otherwise (`d`):\n\n";
    for (const Known& row : documented())
        out += fmt::format("- {}: {}: {}\n", row.cells.column, row.cells.kind, row.why);
    out += "\nKnown to be wrong (`!`):\n\n";
    for (const Known& row : known_wrong())
        out += fmt::format("- {}: {}: {}: {}\n", row.cells.column, row.cells.kind, row.cells.form,
                           row.why);
    return out;
}

}  // namespace openfab::testing
