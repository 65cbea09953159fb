// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/blue_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/slab/void_and_cluster.h"

namespace openfab::slab {
namespace {

double energy(int32_t a, int32_t b, int32_t side) {
    const int32_t dx = std::abs(a % side - b % side), dy = std::abs(a / side - b / side);
    const double x = std::min(dx, side - dx), y = std::min(dy, side - dy);
    return std::exp(-(x * x + y * y) / (2 * 1.5 * 1.5)) + (x == 0 ? 0.125 : 0) +
           (y == 0 ? 0.125 : 0);
}

TEST(VoidAndCluster, EachRankIsInTheLargestVoidOfThoseBefore) {
    for (int32_t side : {4, 7, 16}) {
        const std::vector<uint16_t> ranks = void_and_cluster(side);
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
    for (int32_t line = 0; line < kBlueNoiseSide; ++line) {
        for (int32_t step : {1, kBlueNoiseSide}) {
            std::vector<int32_t> count(64, 0);
            for (int32_t i = 0; i < kBlueNoiseSide; ++i) {
                const int32_t other = step == 1 ? kBlueNoiseSide : 1;
                ++count[kBlueNoiseRanks[line * other + i * step] / 64];
            }
            // One in each 64th would be ideal; by chance some would have 5.
            EXPECT_LE(*std::max_element(count.begin(), count.end()), 4);
        }
    }
}

// The mask is part of what a print is: it must be the same wherever it was made.
TEST(BlueNoise, MaskIsTheSameEverywhere) {
    uint32_t hash = 0;
    for (uint16_t rank : kBlueNoiseRanks)
        hash = abi::mix32(hash ^ rank);
    EXPECT_EQ(hash, 3232907402u);
}

TEST(BlueNoise, ThresholdsOfAColumnAreSpread) {
    // Of any 33 slices one is in each tenth at least twice.
    const uint32_t rank = blue_noise_rank(5, 9, 77);
    for (int32_t first = 0; first < 200; ++first) {
        std::vector<int32_t> tenths(10, 0);
        for (int32_t z = first; z < first + 33; ++z) {
            const int32_t threshold = blue_noise_threshold(rank, z);
            ASSERT_GE(threshold, 0);
            ASSERT_LT(threshold, 65535);
            ++tenths[static_cast<size_t>(threshold / 6553.6)];
        }
        EXPECT_GE(*std::min_element(tenths.begin(), tenths.end()), 2);
    }
}

TEST(BlueNoise, SeedMovesTheMask) {
    EXPECT_NE(blue_noise_rank(3, 4, 1), blue_noise_rank(3, 4, 2));
}

}  // namespace
}  // namespace openfab::slab
