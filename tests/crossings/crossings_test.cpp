// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The table of kinds of geometry by features and tools: each cell is as its twin, within a bound, or refused by
// name. The page docs/crossings.md shows it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <fstream>

#include "tests/crossings/solid.h"
#include "tests/crossings/table.h"
#include "tests/support/long_run.h"
#include "tests/support/places/places.h"

namespace openfab::testing {
namespace {

std::filesystem::path page_file() {
    return source_dir() / "docs/crossings.md";
}

bool updates() {
    return std::getenv("OPENFAB_UPDATE") != nullptr;
}

const Lines& page_lines() {
    static const Lines lines = read_page(read_file(page_file()));
    return lines;
}

bool tries_all() {
    return long_run() || updates();
}

/// A twelfth of the cells, other ones in each column, unless this is a long run.
bool is_tried(size_t column, size_t kind, Form form) {
    constexpr size_t kEach = 12;
    return tries_all() || (5 * column + 7 * kind + static_cast<size_t>(form) * 3) % kEach == 0;
}

/// Puts a line into the page; others stay.
void update_page(const std::string& id, const std::string& line) {
    Lines lines = read_page(read_file(page_file()));
    if (!id.empty()) lines[id] = line;
    std::ofstream(page_file()) << page_of(lines);
}

class Crossings : public ::testing::TestWithParam<size_t> {};

TEST_P(Crossings, AsTheTwinOrRefusedByName) {
    const size_t number = GetParam();
    const Column& column = columns()[number];
    // The page says which lines are still to be made: of those short runs expect nothing.
    if (!tries_all() && page_lines().count(column.id) == 0) return;
    std::string line(place_of(kinds().size(), Form::kWhole) - 1, ' ');
    line.replace(0, column.id.size(), column.id);
    Twins twins;
    std::map<const Known*, int> wrong;
    for (size_t k = 0; k < kinds().size(); ++k) {
        for (const Form form : kForms) {
            if (!is_tried(number, k, form)) continue;
            const Kind& kind = kinds()[k];
            SCOPED_TRACE(fmt::format("{}, {}, {}", column.id, kind.id, name_of(form)));
            const Cell cell = try_cell(column, kind, form, &twins);
            const Known* const known = find(known_wrong(), column, kind, form);
            const size_t at = place_of(k, form);
            line[at] = symbol_of(cell.verdict);
            if (known != nullptr) {
                wrong[known] += cell.verdict == Verdict::kWrong ? 1 : 0;
            } else {
                EXPECT_NE(cell.verdict, Verdict::kWrong) << cell.why;
            }
            if (updates() || known != nullptr) continue;
            const auto expected = page_lines().find(column.id);
            if (expected == page_lines().end()) continue;  // CrossingsPage asks for all lines
            EXPECT_EQ(line[at], expected->second[at]) << "the page says otherwise; " << cell.why;
        }
    }
    // Runs of all cells notice what was mended.
    for (const auto& [row, cells] : wrong)
        EXPECT_TRUE(cells > 0 || !tries_all())
            << "right by now: take it from known_wrong.cpp: " << row->cells.kind << ": "
            << row->why;
    if (updates()) update_page(column.id, line);
}

std::string test_name(const ::testing::TestParamInfo<size_t>& info) {
    std::string out;
    for (const char c : columns()[info.param].id)
        out += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    return out;
}

INSTANTIATE_TEST_SUITE_P(Columns, Crossings, ::testing::Range(size_t{0}, columns().size()),
                         test_name);

// For tests/python/test_kinds.py, which prints these worlds from Python: KIND FORM/w.fab.json, and OPTIONS, a line each.
TEST(CrossingsWorlds, AreWritten) {
    const char* const to = std::getenv("OPENFAB_WORLDS_TO");
    if (to == nullptr) GTEST_SKIP() << "OPENFAB_WORLDS_TO names no folder";
    for (const Kind& kind : kinds()) {
        for (const Form form : kForms) {
            const std::filesystem::path folder =
                std::filesystem::path(to) / fmt::format("{} {}", kind.id, name_of(form));
            std::filesystem::create_directories(folder);
            for (const auto& [name, text] : files_of(kind, form, {}))
                std::ofstream(folder / name) << text;
            std::ofstream options(folder / "OPTIONS");
            for (const std::string& option : kind.options)
                options << option << '\n';
        }
    }
}

// After all columns.
TEST(CrossingsPage, IsCurrent) {
    if (updates()) update_page("", "");
    const std::string page = read_file(page_file());
    EXPECT_EQ(page, page_of(read_page(page)));
    // Lines that no run of all cells has made yet.
    if (long_run()) {
        EXPECT_EQ(page_lines().size(), columns().size());
    }
}

TEST(CrossingsTwin, IsTheClosedForm) {
    const Bench bench(kinds()[0], Form::kWhole, columns()[0].change);
    ASSERT_EQ(bench.print("out.npy", {"--voxel", "0.1mm"}).exit_code, 0);
    const Voxels voxels = read_voxels(bench.path("out.npy"));
    const Hull hull;
    int64_t inside = 0;
    for (int z = 0; z < voxels.size[2]; ++z) {
        for (int y = 0; y < voxels.size[1]; ++y) {
            for (int x = 0; x < voxels.size[0]; ++x) {
                const double d = hull_distance(hull, {voxels.origin_mm[0] + 0.1 * (x + 0.5),
                                                      voxels.origin_mm[1] + 0.1 * (y + 0.5),
                                                      voxels.origin_mm[2] + 0.1 * (z + 0.5)});
                inside += d < 0 ? 1 : 0;
                // Facets, and vertices on 1/256 of a voxel.
                if (std::fabs(d) < kSagitta * hull.radius + 0.1 / 128) continue;
                ASSERT_EQ(voxels.at(x, y, z) != 0, d < 0) << x << " " << y << " " << z;
            }
        }
    }
    EXPECT_GT(inside, 10000);
}

}  // namespace
}  // namespace openfab::testing
