// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bounds of what grows, which culling asks for: of covered voxels they hold, and they make nothing grow.

#include <gtest/gtest.h>

#include "tests/unit/solid/growing.h"

namespace openfab::solid {
namespace {

/// The covered voxels of a block, as a query has them.
std::array<uint8_t, 64> active_in(const Made& made, const std::vector<uint8_t>& covered,
                                  const Vec3i& lowest) {
    std::array<uint8_t, 64> bits{};
    for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
        const Vec3i at = lowest + Vec3i{v >> 3 & 7, v >> 6, v & 7};
        const size_t place =
            (static_cast<size_t>(at.z) * made.grid.size.y + at.y) * made.grid.size.x + at.x;
        if (covered[place] != 0) bits[static_cast<size_t>(v >> 3)] |= 1 << (v & 7);
    }
    return bits;
}

/// Bounds hold the distances and attributes of covered voxels, whatever block was asked for before.
TEST(GrowBounds, HoldWhatCoveredVoxelsHave) {
    const Made all(bush, kernel<bush>, 0, all_of(bush)), made(bush, kernel<bush>, kMuch, nullptr);
    const std::vector<uint8_t> covered = all.covered();
    EXPECT_TRUE(made.covered() == covered);
    const Vec3i base = part::part_base_voxel(made.part, made.grid);
    int64_t compared = 0, told = 0;
    for (int32_t b = 0; b < 12 * 8 * 15; ++b) {
        const Vec3i block = {b % 12 * 8, b / 12 % 8 * 8, b / 96 * 8};
        const std::array<uint8_t, 64> active = active_in(made, covered, block);
        if (std::ranges::count(active, 0) == 64) continue;
        nearest::BlockAnswer answer;
        all.placed->engine()->query({block - base, active.data()}, all.scratch->engine.get(),
                                    &answer);
        std::vector<float> heat(512);
        std::vector<uint32_t> kind(512);
        float* values[] = {heat.data()};
        uint32_t* flat[] = {kind.data()};
        all.placed->read(answer, active.data(), {values, nullptr, flat}, all.scratch.get());
        nearest::BlockBounds pieces;
        const Vec3i lowest = block - base;
        made.placed->engine()->bound_blocks({&lowest, 1}, made.scratch->engine.get(), &pieces);
        const nearest::BlockPieces& cut = made.placed->engine()->pieces();
        nearest::BoxBounds of_cube[3];
        const int32_t half = b % 8;
        const Vec3i octant{4 * (half & 1), 4 * (half >> 1 & 1), 4 * (half >> 2)};
        made.placed->engine()->bounds(lowest, 8, made.scratch->engine.get(), &of_cube[0]);
        made.placed->engine()->bounds(lowest + octant, 4, made.scratch->engine.get(), &of_cube[1]);
        made.placed->engine()->bounds(lowest, 64, made.scratch->engine.get(), &of_cube[2]);
        told += of_cube[0].count > 0 && of_cube[0].cases[0].float_hi[0] < 100 ? 1 : 0;
        for (int32_t v = 0; v < nearest::kBlockVoxels; ++v) {
            if ((active[static_cast<size_t>(v >> 3)] >> (v & 7) & 1) == 0) continue;
            const float d = std::sqrt(answer.distance2[v]);
            const Vec3i at{v >> 3 & 7, v >> 6, v & 7};
            const auto inside = [&](const Vec3i& low, const Vec3i& size) {
                const Vec3i from = at - low;
                return from.x >= 0 && from.y >= 0 && from.z >= 0 && from.x < size.x &&
                       from.y < size.y && from.z < size.z;
            };
            for (size_t q = 0; q < cut.lowest.size(); ++q) {
                if (!inside(cut.lowest[q], cut.size)) continue;
                ASSERT_LE(d, pieces.high[q]);
                ASSERT_GE(d, pieces.low[q]);
            }
            for (size_t k = 0; k < 3; ++k) {
                if (k == 1 && !inside(octant, {4, 4, 4})) continue;
                const nearest::BoxBounds& bounds = of_cube[k];
                ASSERT_LE(d, bounds.distance_hi);
                bool any = bounds.count == 0;  // nothing is said
                for (int32_t c = 0; c < bounds.count; ++c) {
                    const nearest::NearestCase& one = bounds.cases[static_cast<size_t>(c)];
                    const auto number = static_cast<int32_t>(kind[static_cast<size_t>(v)]);
                    const float warm = heat[static_cast<size_t>(v)];
                    any = any || (one.distance_lo <= d && one.float_lo[0] <= warm &&
                                  warm <= one.float_hi[0] && one.int_lo[0] <= number &&
                                  number <= one.int_hi[0]);
                }
                ASSERT_TRUE(any) << k;
            }
            ++compared;
        }
    }
    EXPECT_GT(compared, 2000);
    EXPECT_GT(told, 20);
}

/// Bounds make nothing grow: they tell what is kept.
TEST(GrowBounds, MakeNothing) {
    const Made made(bush, kernel<bush>, kMuch, nullptr);
    const Vec3i base = part::part_base_voxel(made.part, made.grid);
    const auto told = [&] {
        int64_t blocks = 0;
        for (int32_t b = 0; b < 12 * 8 * 15; ++b) {
            const Vec3i lowest = Vec3i{b % 12 * 8, b / 12 % 8 * 8, b / 96 * 8} - base;
            nearest::BoxBounds bounds;
            nearest::BlockBounds pieces;
            for (const int32_t size : {64, 32, 16, 8})
                made.placed->engine()->bounds(lowest, size, made.scratch->engine.get(), &bounds);
            made.placed->engine()->bound_blocks({&lowest, 1}, made.scratch->engine.get(), &pieces);
            EXPECT_EQ(bounds.count > 0, pieces.high[0] < kInfinity);
            blocks += bounds.count > 0 ? 1 : 0;
        }
        return blocks;
    };
    const int64_t before = nodes_made, first = told();
    EXPECT_EQ(nodes_made, before);
    made.covered();
    const int64_t kept = nodes_made;
    EXPECT_GT(kept, before + 2000);
    EXPECT_GT(told(), first + 50);
    EXPECT_EQ(nodes_made, kept);
}

}  // namespace
}  // namespace openfab::solid
