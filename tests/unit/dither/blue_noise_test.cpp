// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/blue_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "runtime/dither/void_and_cluster.h"
#include "tests/support/reference/blue_noise.h"

namespace openfab::dither {
namespace {

constexpr auto kSide = static_cast<int32_t>(kBlueNoiseSide);
constexpr BlueNoiseFace kInside = BlueNoiseFace::kInside;

/// The rank that a threshold was made from, before rotation; one more if that was 0.
int32_t rank_at(const Vec3i& voxel, BlueNoiseFace face, uint32_t seed) {
    const auto drifted =
        static_cast<uint32_t>(reference::blue_noise_threshold(voxel, face, seed) + 1);
    return static_cast<int32_t>((drifted - blue_noise_drift(voxel.x, voxel.y, voxel.z)) & 0xffff);
}

/// Statistics of windows 8 wide.
double both(double distance, double width = 8) {
    return std::max(1 - distance / width, 0.0);
}

/// Returns how strongly pixel a repels b if the mask moves by (1, 2) from slice to slice.
double energy(int32_t a, int32_t b, int32_t side) {
    double sum = 0;
    for (int32_t slice = -side; slice < side; ++slice) {
        const int32_t dx = std::abs(a % side - b % side + slice) % side,
                      dy = std::abs(a / side - b / side + 2 * slice) % side;
        const double x = std::min(dx, side - dx), y = std::min(dy, side - dy);
        const double gaussian = std::exp(-(x * x + y * y) / (2 * 1.5 * 1.5));
        if (slice == 0) sum += gaussian + (x == 0 ? 0.125 : 0) + (y == 0 ? 0.125 : 0);
        if (slice == 0) sum += 0.1 * (both(x) + both(y));
        const double z = std::abs(slice);
        sum += 0.02 * (both(x) * both(y) * both(z, side) + both(z) * (both(x) + both(y)));
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
        std::vector<int32_t> position(ranks.size(), -1);
        for (int32_t p = 0; p < pixels; ++p)
            position[ranks[p]] = p;
        ASSERT_EQ(std::count(position.begin(), position.end(), -1), 0) << "a permutation";
        for (int32_t rank = 0; rank < pixels; ++rank) {
            double least = 1e30, own = 0;
            for (int32_t later = rank; later < pixels; ++later) {
                double sum = 0;
                for (int32_t before = 0; before < rank; ++before)
                    sum += energy(position[later], position[before], side);
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
                const int32_t threshold =
                    reference::blue_noise_threshold(start + step * i, kInside, 77);
                ASSERT_GE(threshold, 0);
                ASSERT_LT(threshold, 65535);
                ++count[static_cast<size_t>(threshold / 4096)];
            }
            // 3.8 in each 16th would be ideal; in white noise some would have 12.
            EXPECT_LE(*std::max_element(count.begin(), count.end()), 8);
        }
    }
}

// The property that gives vertical and 45 degree layers their means.
TEST(BlueNoise, EveryLayerMeetsEveryPixelOnce) {
    const Vec3i normals[] = {{1, 0, 0}, {0, 1, 0},  {1, 1, 0}, {1, -1, 0},
                             {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    std::vector<int32_t> expected;
    for (int32_t y = 0; y < kSide; ++y) {
        for (int32_t x = 0; x < kSide; ++x)
            expected.push_back(rank_at({x, y, 0}, kInside, 5));
    }
    std::sort(expected.begin(), expected.end());
    for (const Vec3i& normal : normals) {
        std::vector<int32_t> found;
        for (int32_t z = 0; z < kSide; ++z) {
            for (int32_t i = 0; i < kSide; ++i) {
                // Solved for x where the normal has one, else for y.
                const int32_t at =
                    normal.x != 0 ? 100 - normal.y * i - normal.z * z : 100 - normal.z * z;
                const Vec3i voxel = normal.x != 0 ? Vec3i{at, i, z} : Vec3i{i, at, z};
                found.push_back(rank_at(voxel, kInside, 5));
            }
        }
        std::sort(found.begin(), found.end());
        for (size_t i = 0; i < found.size(); ++i)
            ASSERT_NEAR(found[i], expected[i], 1) << normal.x << " " << normal.y << " " << normal.z;
    }
}

TEST(BlueNoise, GoesOnBelowZero) {
    for (const Vec3i& step : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
        for (int32_t i = -2 * kSide; i < kSide; ++i) {
            const Vec3i at = Vec3i{5, 7, 11} + step * i;
            EXPECT_NEAR(rank_at(at, kInside, 9), rank_at(at + step * kSide, kInside, 9), 1)
                << at.x << " " << at.y << " " << at.z;
        }
    }
}

// The mask determines prints: it must be the same wherever it is built.
TEST(BlueNoise, MaskIsTheSameEverywhere) {
    uint32_t hash = 0;
    for (uint16_t rank : kBlueNoiseMask)
        hash = abi::mix32(hash ^ rank);
    EXPECT_EQ(hash, 1258889364u);
}

TEST(BlueNoise, SeedMovesTheMask) {
    int32_t same = 0;
    for (int32_t x = 0; x < 100; ++x) {
        same += reference::blue_noise_threshold({x, 4, 2}, kInside, 1) ==
                        reference::blue_noise_threshold({x, 4, 2}, kInside, 2)
                    ? 1
                    : 0;
    }
    EXPECT_LT(same, 5);
}

// A fraction below the mask's levels is printed in proportion, neither everywhere nor nowhere.
TEST(BlueNoise, PrintsFractionsBelowItsLevels) {
    for (int32_t fraction : {9, 12, 16}) {
        int32_t printed = 0;
        for (int32_t z = 0; z < 200; ++z) {
            for (int32_t y = 0; y < kSide; ++y) {
                for (int32_t x = 0; x < kSide; ++x)
                    printed +=
                        reference::blue_noise_threshold({x, y, z}, kInside, 3) < fraction ? 1 : 0;
            }
        }
        const double asked = fraction / 65535.0 * 200 * kSide * kSide;
        EXPECT_NEAR(printed / asked, 1.0, 0.1) << fraction;
    }
}

// The pattern of a side is the mask, not sections through it.
TEST(BlueNoise, SidesHaveTheMaskInTheirPlane) {
    using enum BlueNoiseFace;
    for (const BlueNoiseFace face : {kLowX, kHighX, kLowY, kHighY}) {
        const bool x_side = face == kLowX || face == kHighX;
        std::vector<int32_t> found, ranks(std::begin(kBlueNoiseMask), std::end(kBlueNoiseMask));
        for (int32_t z = -30; z < kSide - 30; ++z) {
            for (int32_t i = -7; i < 2 * kSide - 7; ++i) {
                const Vec3i voxel = x_side ? Vec3i{5, i, z} : Vec3i{i, 5, z};
                found.push_back(rank_at(voxel, face, 3));
                const Vec3i behind = voxel + (x_side ? Vec3i{9, 0, 0} : Vec3i{0, 9, 0});
                ASSERT_NEAR(found.back(), rank_at(behind, face, 3), 1);
            }
        }
        const auto turn = static_cast<int32_t>(BlueNoiseOffset(3, face).turn);
        for (int32_t& rank : ranks)
            rank = (rank + turn) & 0xffff;
        std::sort(found.begin(), found.end());
        std::sort(ranks.begin(), ranks.end());
        ASSERT_EQ(found.size(), ranks.size());
        for (size_t i = 0; i < ranks.size(); ++i)
            ASSERT_NEAR(found[i], ranks[i], 1);
    }
}

BlueNoiseNeighbours neighbours(const char* rows) {
    const auto at = [&](int32_t i) { return rows[i] == '#' ? 255u : 0u; };
    return {at(4), at(3), at(5), at(1), at(7), at(0), at(2), at(6), at(8)};
}

// Rows in ascending y, each in ascending x; the voxel is the one in the middle.
TEST(BlueNoise, FacesOfAVoxel) {
    struct Case {
        const char* rows;
        const char* face;
    };
    const Case cases[] = {
        {"#########", "-"},  {".########", "-"},                       // inside
        {".##.##.##", "-x"}, {"##.##.##.", "+x"},                      // flat
        {"...######", "-y"}, {"######...", "+y"},                      //
        {".#..#..#.", "-x"}, {"...###...", "-y"},                      // walls
        {"....#....", "-x"}, {"####.####", "-"},                       // alone; not mixed
        {"....##.##", "-x"}, {"##.##....", "+x"},                      // corners of a square
        {"..#.##.##", "-x"}, {"..#.#####", "-x"},                      // steep, 45 degrees
        {"....#####", "-y"}, {"...##.###", "-y"},                      // steps along x
        {"###.##...", "+y"}, {"#####....", "+y"}, {"......###", "-"},  //
    };
    for (const Case& c : cases) {
        const BlueNoiseFaces faces(neighbours(c.rows));
        std::string found;
        if ((faces.low_x & 255) != 0) found += "-x";
        if ((faces.high_x & 255) != 0) found += "+x";
        if ((faces.low_y & 255) != 0) found += "-y";
        if ((faces.high_y & 255) != 0) found += "+y";
        EXPECT_EQ(found.empty() ? "-" : found, c.face) << c.rows;
    }
}

}  // namespace
}  // namespace openfab::dither
