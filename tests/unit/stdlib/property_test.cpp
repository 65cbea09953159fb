// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Tables of mixtures: each row is met exactly, what lies between is linear, what lies beyond is the
// nearer end, whether values rise or fall.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/unit/stdlib/library_function.h"

namespace openfab::testing {
namespace {

struct Row {
    double value;
    std::array<double, 3> mixture;
};

/// Not linear anywhere, of three materials.
const std::vector<Row> kRows = {
    {0.6, {1, 0, 0}}, {2.4, {0.75, 0.25, 0}}, {18, {0.25, 0.5, 0.25}}, {2000, {0, 0, 1}}};

std::string table(bool falls) {
    std::string values, mixtures;
    for (size_t i = 0; i < 16; ++i) {
        Row row{0, {}};
        if (i < kRows.size()) row = kRows[falls ? kRows.size() - 1 - i : i];
        const std::string comma = i == 0 ? "" : ", ";
        values += comma + std::to_string(row.value);
        mixtures += comma + "float4(" + std::to_string(row.mixture[0]) + ", " +
                    std::to_string(row.mixture[1]) + ", " + std::to_string(row.mixture[2]) + ", 0)";
    }
    return "PropertyTable rows = {4, {" + values + "}, {" + mixtures + "}}; ";
}

TEST(Property, RowsAreMetExactlyAndLinearBetween) {
    for (const bool falls : {false, true}) {
        for (size_t c = 0; c < 3; ++c) {
            const LibraryFunction part(
                "property",
                table(falls) + "return property_fractions(rows, t)[" + std::to_string(c) + "];");
            for (size_t i = 0; i < kRows.size(); ++i) {
                EXPECT_EQ(part({}, kRows[i].value), kRows[i].mixture[c]) << falls << i << c;
                if (i == 0) continue;
                const double a = kRows[i - 1].value, b = kRows[i].value;
                for (const double along : {0.25, 0.5, 0.9}) {
                    const double expected =
                        kRows[i - 1].mixture[c] * (1 - along) + kRows[i].mixture[c] * along;
                    EXPECT_NEAR(part({}, a + (b - a) * along), expected, 1e-6);
                }
            }
            EXPECT_EQ(part({}, -5), kRows.front().mixture[c]) << "the nearer end";
            EXPECT_EQ(part({}, 1e9), kRows.back().mixture[c]);
            EXPECT_TRUE(std::isfinite(part({}, std::nan(""))));
        }
        const LibraryFunction low("property", table(falls) + "return property_lowest(rows);");
        const LibraryFunction high("property", table(falls) + "return property_highest(rows);");
        EXPECT_FLOAT_EQ(static_cast<float>(low({})), 0.6F);
        EXPECT_EQ(high({}), 2000);
    }
}

}  // namespace
}  // namespace openfab::testing
