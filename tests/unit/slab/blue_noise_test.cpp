// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/blue_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/slab/void_and_cluster.h"

namespace openfab::slab {
namespace {

constexpr auto kSide = static_cast<int32_t>(kBlueNoiseSide);

/// How much pixel a repels b, where the mask moves by (1, 2) from slice to slice.
double energy(int32_t a, int32_t b, int32_t side) {
    double sum = 0;
    for (int32_t slice = -side; slice < side; ++slice) {
        const int32_t dx = std::abs(a % side - b % side + slice) % side,
                      dy = std::abs(a / side - b / side + 2 * slice) % side;
        const double x = std::min(dx, side - dx), y = std::min(dy, side - dy);
        const double gaussian = std::exp(-(x * x + y * y) / (2 * 1.5 * 1.5));
        if (slice == 0) sum += gaussian + (x == 0 ? 0.125 : 0) + (y == 0 ? 0.125 : 0);
        if (std::abs(slice) == 1) sum += 0.2 * gaussian;
        if (std::abs(slice) == 2) sum += 0.05 * gaussian;
        if (slice >= 0 && x == 0 && y == 0) sum += 0.125;
    }
    return sum;
}

TEST(VoidAndCluster, EachRankIsInTheLargestVoidOfThoseBefore) {
    for (int32_t side : {4, 7, 16}) {
        const std::vector<uint16_t> ranks = void_and_cluster(side, 1, 2);
        const int32_t pixels = side * side;
        ASSERT_EQ(ranks.size(), static_cast<size_t>(pixels));
        std::vector<int32_t> place(ranks.size(), -1);
        for (int32_t p = 0; p < pixels; ++p)
            place[ranks[static_cast<size_t>(p)]] = p;
        ASSERT_EQ(std::count(place.begin(), place.end(), -1), 0) << "a permutation";
        for (int32_t rank = 0; rank < pixels; ++rank) {
            double least = 1e30, own = 0;
            for (int32_t later = rank; later < pixels; ++later) {
                double sum = 0;
                for (int32_t before = 0; before < rank; ++before)
                    sum += energy(place[static_cast<size_t>(later)],
                                  place[static_cast<size_t>(before)], side);
                least = std::min(least, sum);
                if (later == rank) own = sum;
            }
            // Sums are rounded to 2^-32 a pixel.
            ASSERT_NEAR(own, least, 1e-6) << "side " << side << ", rank " << rank;
        }
    }
}

TEST(BlueNoise, EveryLineHasItsShareOfEveryRangeOfRanks) {
    // In a slice along x and y, and along z.
    for (const Vec3i& step : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
        for (int32_t line = 0; line < kSide * kSide; ++line) {
            std::vector<int32_t> count(16, 0);
            for (int32_t i = 0; i < kSide; ++i) {
                const int32_t a = line % kSide, b = line / kSide;
                const Vec3i start = step.x == 1   ? Vec3i{0, a, b}
                                    : step.y == 1 ? Vec3i{a, 0, b}
                                                  : Vec3i{a, b, 0};
                const int32_t threshold = blue_noise_threshold(start + step * i, 77);
                ASSERT_GE(threshold, 0);
                ASSERT_LT(threshold, 65535);
                ++count[static_cast<size_t>(threshold / 4096)];
            }
            // 3.8 in each 16th would be ideal; by chance some would have 12.
            EXPECT_LE(*std::max_element(count.begin(), count.end()), 8);
        }
    }
}

// What upright layers and those at 45 degrees owe their means to.
TEST(BlueNoise, EveryLayerMeetsEveryPixelOnce) {
    const Vec3i normals[] = {{1, 0, 0}, {0, 1, 0},  {1, 1, 0}, {1, -1, 0},
                             {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    std::vector<int32_t> expected;
    for (int32_t y = 0; y < kSide; ++y) {
        for (int32_t x = 0; x < kSide; ++x)
            expected.push_back(blue_noise_threshold({x, y, 0}, 5));
    }
    std::sort(expected.begin(), expected.end());
    for (const Vec3i& normal : normals) {
        std::vector<int32_t> found;
        for (int32_t z = 0; z < kSide; ++z) {
            for (int32_t i = 0; i < kSide; ++i) {
                // Solved for x where the normal has one, else for y.
                const int32_t at =
                    normal.x != 0 ? 100 - normal.y * i - normal.z * z : 100 - normal.z * z;
                found.push_back(
                    blue_noise_threshold(normal.x != 0 ? Vec3i{at, i, z} : Vec3i{i, at, z}, 5));
            }
        }
        std::sort(found.begin(), found.end());
        EXPECT_EQ(found, expected) << normal.x << " " << normal.y << " " << normal.z;
    }
}

TEST(BlueNoise, GoesOnBelowZero) {
    for (const Vec3i& step : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
        for (int32_t i = -2 * kSide; i < kSide; ++i) {
            const Vec3i at = Vec3i{5, 7, 11} + step * i;
            EXPECT_EQ(blue_noise_threshold(at, 9), blue_noise_threshold(at + step * kSide, 9))
                << at.x << " " << at.y << " " << at.z;
        }
    }
}

// The mask is part of what a print is: it must be the same wherever it was made.
TEST(BlueNoise, MaskIsTheSameEverywhere) {
    uint32_t hash = 0;
    for (uint16_t rank : kBlueNoiseMask)
        hash = abi::mix32(hash ^ rank);
    EXPECT_EQ(hash, 940113132u);
}

TEST(BlueNoise, SeedMovesTheMask) {
    int32_t same = 0;
    for (int32_t x = 0; x < 100; ++x)
        same += blue_noise_threshold({x, 4, 2}, 1) == blue_noise_threshold({x, 4, 2}, 2) ? 1 : 0;
    EXPECT_LT(same, 5);
}

}  // namespace
}  // namespace openfab::slab
