// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/nozzles/nozzles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace openfab::process {
namespace {

/// Counts the voxels of a box of a grid by the machine's row, or layer, that they count as.
std::map<int64_t, int64_t> count(const MachineRows& rows, const Vec3i& size, bool layers) {
    std::map<int64_t, int64_t> out;
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                const Vec3i voxel{x, y, z};
                const int64_t found = layers ? rows.layer(voxel) : rows.row(voxel);
                const Vec2<int64_t> all = layers ? rows.layers(z) : rows.rows(y);
                EXPECT_GE(found, all.x);
                EXPECT_LE(found, all.y);
                ++out[found];
            }
        }
    }
    return out;
}

TEST(Nozzles, RowsOfTheMachineHaveTheirShareOfADraft) {
    for (const double rate : {2.0, 2.5, 3.0, 4.0, 8.0, 16.0, 16.7}) {
        const MachineRows rows{0, rate, 0, rate};
        const Vec3i size{12, 12, 12};
        for (const bool layers : {false, true}) {
            // A row that is not cut by the box's end has a plane of voxels, over the rate.
            const double share = 144 / rate;
            for (const auto& [row, voxels] : count(rows, size, layers)) {
                if (static_cast<double>(row + 1) > rate * 12) continue;
                EXPECT_NEAR(static_cast<double>(voxels), share, 0.1 * share + 4.5)
                    << rate << " " << row << " " << layers;
            }
        }
    }
}

TEST(Nozzles, AtTheMachinesPitchAVoxelIsOfTheRowOfItsMiddle) {
    for (const double rate : {1.0, 0.5, 0.25}) {
        const MachineRows rows{-3, rate, 7, rate};
        for (int32_t k = 0; k < 40; ++k) {
            for (const int32_t x : {0, 1, 17}) {
                EXPECT_EQ(rows.row({x, k, 5}),
                          static_cast<int64_t>(std::floor(-3 + (k + 0.5) * rate)));
                EXPECT_EQ(rows.layer({x, 5, k}),
                          static_cast<int64_t>(std::floor(7 + (k + 0.5) * rate)));
            }
        }
    }
}

}  // namespace
}  // namespace openfab::process
