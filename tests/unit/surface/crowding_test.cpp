// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/crowding.h"

#include <gtest/gtest.h>

namespace openfab::surface {
namespace {

Patch tile(int32_t triangle, const std::array<int32_t, 4>& lattice, const Box3f& bounds) {
    Patch patch;
    patch.kind = PatchKind::kLattice;
    patch.triangle = triangle;
    patch.lattice = lattice;
    patch.bounds = bounds;
    return patch;
}

const Box3f kWhole{{0, 0, 0}, {4, 4, 4}};

TEST(Crowding, IsTheMicropolygonsOfEachTileTimesTheShareOfItsBox) {
    // The lattice of factor 40 has 1600 triangles: 32² · 2 - 24² of the tile at corner 0, 64 of
    // each at the others.
    const std::vector<Patch> patches{
        tile(0, {0, 0, 32, 32}, {{0, 0, 0}, {2, 2, 2}}), tile(0, {32, 0, 40, 8}, kWhole),
        tile(0, {0, 32, 8, 40}, kWhole), tile(1, {0, 0, 1, 1}, kWhole)};
    EXPECT_DOUBLE_EQ(crowding(patches), 1472 / 8.0 + 64 + 64 + 1);
}

TEST(Crowding, CountsNoWholeTrianglesButTheirBoxes) {
    Patch whole;
    whole.triangle = 7;
    whole.bounds = kWhole;
    EXPECT_EQ(crowding({whole}), 0);
    EXPECT_DOUBLE_EQ(crowding({whole, tile(8, {0, 0, 4, 4}, {{0, 0, 0}, {4, 4, 2}})}), 16 / 2.0);
}

TEST(Crowding, IsZeroWithoutVolume) {
    EXPECT_EQ(crowding({}), 0);
    EXPECT_EQ(crowding({tile(0, {0, 0, 4, 4}, {{0, 0, 0}, {4, 4, 0}})}), 0);
}

}  // namespace
}  // namespace openfab::surface
