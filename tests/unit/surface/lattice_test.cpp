// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/lattice.h"

#include <gtest/gtest.h>

#include <set>

namespace openfab::surface {
namespace {

TEST(Lattice, EdgeFactorRoundsUpAndIsSymmetric) {
    const Vec3d a{0, 0, 0}, b{3, 4, 0};
    EXPECT_EQ(edge_factor(a, b, 1), 5);
    EXPECT_EQ(edge_factor(a, b, 1.0001), 5);
    EXPECT_EQ(edge_factor(a, b, 0.9999), 6);
    EXPECT_EQ(edge_factor(a, b, 100), 1);
    EXPECT_EQ(edge_factor(a, a, 1), 1);
    EXPECT_EQ(edge_factor(a, b, 5.0 / 65535), 65535);
    EXPECT_EQ(edge_factor(a, b, 5.0 / 70000), kMaxEdgeFactor + 1);
    const Vec3d c{0.1, 0.7, -0.3};
    EXPECT_EQ(edge_factor(b, c, 0.001), edge_factor(c, b, 0.001));
}

TEST(Lattice, SnappingIsMonotoneAndReachesEveryEdgePoint) {
    for (int32_t n = 1; n <= 40; ++n) {
        for (int32_t factor = 1; factor <= n; ++factor) {
            int32_t last = snap_to_edge(0, factor, n);
            EXPECT_EQ(last, 0);
            for (int32_t l = 1; l <= n; ++l) {
                const int32_t i = snap_to_edge(l, factor, n);
                ASSERT_GE(i, last);
                ASSERT_LE(i, last + 1);
                last = i;
            }
            EXPECT_EQ(last, factor);
        }
    }
}

TEST(Lattice, TilesCoverEveryCellOnce) {
    for (const int32_t n : {1, 2, 31, 32, 33, 64, 65, 100}) {
        std::set<std::array<int32_t, 2>> seen;
        int32_t number = 0;
        for (int32_t row = 0; row < tile_rows(n); ++row) {
            for (int32_t column = 0; column + row < tile_rows(n); ++column, ++number) {
                EXPECT_EQ(tile_number(n, column, row), number);
                const Tile tile = tile_at(n, column, row);
                EXPECT_LT(tile.a0, tile.a1);
                EXPECT_LT(tile.b0, tile.b1);
                for (int32_t a = tile.a0; a < tile.a1; ++a) {
                    for (int32_t b = tile.b0; b < tile.b1 && a + b < n; ++b) {
                        EXPECT_TRUE(seen.insert({a, b}).second);
                    }
                }
            }
        }
        EXPECT_EQ(number, tile_count(n));
        EXPECT_EQ(seen.size(), static_cast<size_t>(n) * static_cast<size_t>(n + 1) / 2);
    }
}

TEST(Lattice, TileOfPointHasThePoint) {
    for (const int32_t n : {1, 5, 32, 33, 64, 96, 97}) {
        for (int32_t a = 0; a <= n; ++a) {
            for (int32_t b = 0; a + b <= n; ++b) {
                const int32_t number = tile_of_point(n, a, b);
                bool found = false;
                for (int32_t row = 0; row < tile_rows(n); ++row) {
                    for (int32_t column = 0; column + row < tile_rows(n); ++column) {
                        if (tile_number(n, column, row) != number) continue;
                        const Tile t = tile_at(n, column, row);
                        found = t.a0 <= a && a <= t.a1 && t.b0 <= b && b <= t.b1;
                    }
                }
                ASSERT_TRUE(found) << "n " << n << " a " << a << " b " << b;
            }
        }
    }
}

TEST(Lattice, EdgePositionsMeetTheirEnds) {
    const Vec3d lo{-1.3, 0.7, 2}, hi{4.1, 0.7, -5};
    EXPECT_EQ(edge_position(lo, hi, 0, 7), lo);
    EXPECT_EQ(edge_position(lo, hi, 7, 7), hi);
    for (int32_t i = 0; i <= 7; ++i)
        EXPECT_EQ(edge_position(lo, hi, i, 7).y, 0.7);
    EXPECT_EQ(edge_value(0.1f, 0.9f, 7, 7), 0.9f);
}

TEST(Lattice, NormalsThatCancelFallBack) {
    const Vec3f ng{0, 0, 1};
    EXPECT_EQ(unit_normal({0, 0, 0}, ng), ng);
    EXPECT_EQ(unit_normal({std::numeric_limits<float>::quiet_NaN(), 0, 0}, ng), ng);
    EXPECT_EQ(unit_normal({0, 3, 4}, ng), (Vec3f{0, 0.6f, 0.8f}));
}

}  // namespace
}  // namespace openfab::surface
