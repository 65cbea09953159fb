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

constexpr auto kRow = static_cast<int32_t>(kBlueNoiseRow);
constexpr auto kPixels = static_cast<int32_t>(kBlueNoisePixels);
constexpr BlueNoiseFace kInside = BlueNoiseFace::kInside;

/// The rank that a threshold was made from, before rotation; one more if that was 0.
int32_t rank_at(const Vec3i& voxel, BlueNoiseFace face, uint32_t seed) {
    const auto drifted =
        static_cast<uint32_t>(reference::blue_noise_threshold(voxel, face, seed) + 1);
    return static_cast<int32_t>((drifted - blue_noise_drift(voxel.x, voxel.y, voxel.z)) & 0xffff);
}

/// How a pixel repels the others, by difference of their numbers, in a mask with this many pixels a
/// row that moves by 5 pixels from slice to slice.
class Repulsion {
  public:
    Repulsion(int32_t row, MaskUse use)
        : row_(row), pixels_(row * row + 1), inside_(use == MaskUse::kInside) {
        all_ = sums(0.06, 0.015, {{1.5, 1}, {2.7, 0.25}, {4.86, 0.0625}});
        for (Last& last : last_) {
            last.sums = sums(last.line, last.rod, {{0.65 * std::sqrt(last.part), 0.3}});
        }
    }

    /// Returns the energy of a pixel if the first pixels of `order` have ranks.
    double energy(int32_t pixel, const std::vector<int32_t>& order, int32_t first) const {
        double sum = 0;
        for (int32_t rank = 0; rank < first; ++rank) {
            const int32_t from = modulo(pixel - order[rank]);
            sum += all_[from];
            for (const Last& last : last_)
                sum += rank < first - pixels_ / last.part ? 0 : last.sums[from];
        }
        return sum;
    }

  private:
    struct Gaussian {
        double sigma, weight;
    };
    struct Last {
        int32_t part;
        double line, rod;
        std::vector<double> sums;
    };

    int32_t modulo(int32_t i) const { return (i % pixels_ + pixels_) % pixels_; }

    std::vector<double> sums(double line, double rod,
                             const std::vector<Gaussian>& gaussians) const {
        std::vector<double> result;
        for (int32_t p = 0; p < pixels_; ++p) {
            double sum = line * (boxes(p, 64, 1, 1) + boxes(p, 1, 64, 1));
            if (inside_) {
                sum += line * boxes(p, 1, 1, 64);
                sum += rod * (boxes(p, 6, 6, 64) + boxes(p, 64, 6, 8) + boxes(p, 6, 64, 8));
            } else {
                sum += rod *
                       (2 * boxes(p, 8, 64, 1) + 2 * boxes(p, 6, 64, 1) + 4 * boxes(p, 64, 8, 1));
            }
            for (const Gaussian& gaussian : gaussians) {
                for (int32_t slice = -2; slice <= 2; ++slice) {
                    if (slice != 0 && !inside_) continue;
                    const double weight = slice == 0 ? 1 : std::abs(slice) == 1 ? 0.15 : 0.04;
                    sum += weight * gaussian.weight *
                           std::exp(-square_distance(p + 5 * slice) /
                                    (2 * gaussian.sigma * gaussian.sigma));
                }
            }
            result.push_back(sum);
        }
        return result;
    }

    /// A 64th of the boxes of x by y by z voxels that hold two pixels.
    double boxes(int32_t difference, int32_t x, int32_t y, int32_t z) const {
        int32_t sum = 0;
        for (int32_t k = 1 - z; k < z; ++k) {
            for (int32_t j = 1 - y; j < y; ++j) {
                for (int32_t i = 1 - x; i < x; ++i) {
                    if (modulo(i - row_ * j + 5 * k - difference) == 0)
                        sum += (x - std::abs(i)) * (y - std::abs(j)) * (z - std::abs(k));
                }
            }
        }
        return sum / 64.0;
    }

    double square_distance(int32_t difference) const {
        double least = 1e30;
        for (int32_t y = -row_; y <= row_; ++y) {
            for (int32_t x = -row_; x <= row_; ++x) {
                if (modulo(x - row_ * y - difference) == 0)
                    least = std::min(least, 1.0 * x * x + 1.0 * y * y);
            }
        }
        return least;
    }

    int32_t row_, pixels_;
    bool inside_;
    std::vector<double> all_;
    std::vector<Last> last_ = {{200, 0.03, 0.025, {}}, {100, 0.09, 0.075, {}},
                               {50, 0.03, 0.025, {}},  {20, 0.03, 0.005, {}},
                               {10, 0.03, 0, {}},      {4, 0.03, 0, {}}};
};

TEST(VoidAndCluster, EachRankIsInTheLargestVoidOfThoseBefore) {
    for (const MaskUse use : {MaskUse::kSides, MaskUse::kInside}) {
        for (int32_t row : {4, 7, 16}) {
            const Repulsion repulsion(row, use);
            const std::vector<uint16_t> ranks = void_and_cluster(row, use, 5);
            const int32_t pixels = row * row + 1;
            ASSERT_EQ(ranks.size(), static_cast<size_t>(pixels));
            std::vector<int32_t> order(ranks.size(), -1);
            for (int32_t p = 0; p < pixels; ++p)
                order[ranks[p]] = p;
            ASSERT_EQ(std::count(order.begin(), order.end(), -1), 0) << "a permutation";
            for (int32_t rank = 0; rank < pixels; ++rank) {
                const double own = repulsion.energy(order[rank], order, rank);
                double least = own;
                for (int32_t later = rank + 1; later < pixels; ++later)
                    least = std::min(least, repulsion.energy(order[later], order, rank));
                // Sums are rounded to 2^-32 a pixel.
                ASSERT_NEAR(own, least, 1e-6) << "row " << row << ", rank " << rank;
            }
        }
    }
}

TEST(BlueNoise, EveryLineHasItsShareOfEveryRangeOfRanks) {
    // In a slice along x and y, and along z.
    for (const Vec3i& step : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
        for (int32_t line = 0; line < kRow * kRow; ++line) {
            std::vector<int32_t> count(16, 0);
            for (int32_t i = 0; i < kRow; ++i) {
                const int32_t a = line % kRow, b = line / kRow;
                const Vec3i start = step.x == 1   ? Vec3i{0, a, b}
                                    : step.y == 1 ? Vec3i{a, 0, b}
                                                  : Vec3i{a, b, 0};
                const int32_t threshold =
                    reference::blue_noise_threshold(start + step * i, kInside, 77);
                ASSERT_GE(threshold, 0);
                ASSERT_LT(threshold, 65535);
                ++count[static_cast<size_t>(threshold / 4096)];
            }
            // 4 in each 16th would be ideal; in white noise some would have 13.
            EXPECT_LE(*std::max_element(count.begin(), count.end()), 9);
        }
    }
}

// The property that gives vertical and 45 degree layers their means.
TEST(BlueNoise, EveryLayerMeetsPixelsAllOverTheMask) {
    const Vec3i normals[] = {{1, 0, 0}, {0, 1, 0},  {1, 1, 0}, {1, -1, 0},
                             {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    for (const Vec3i& normal : normals) {
        std::vector<int32_t> sixteenths(16, 0);
        for (int32_t z = 0; z < kRow; ++z) {
            for (int32_t i = 0; i < kRow; ++i) {
                // Solved for x where the normal has one, else for y.
                const int32_t at =
                    normal.x != 0 ? 100 - normal.y * i - normal.z * z : 100 - normal.z * z;
                const Vec3i voxel = normal.x != 0 ? Vec3i{at, i, z} : Vec3i{i, at, z};
                ++sixteenths[static_cast<size_t>(rank_at(voxel, kInside, 5) / 4096)];
            }
        }
        // White noise: 256, and 16 more or less.
        for (int32_t count : sixteenths)
            EXPECT_NEAR(count, 256, 24) << normal.x << " " << normal.y << " " << normal.z;
    }
}

TEST(BlueNoise, GoesOnBelowZero) {
    for (const Vec3i& step : {Vec3i{1, 0, 0}, Vec3i{0, 1, 0}, Vec3i{0, 0, 1}}) {
        for (int32_t i = -2 * kRow; i < kRow; ++i) {
            const Vec3i at = Vec3i{5, 7, 11} + step * i;
            EXPECT_NEAR(rank_at(at, kInside, 9), rank_at(at + step * kPixels, kInside, 9), 1)
                << at.x << " " << at.y << " " << at.z;
        }
    }
}

// A line of voxels goes on in the next line of the mask.
TEST(BlueNoise, LinesDoNotRepeat) {
    for (const Vec3i& at : {Vec3i{5, 7, 11}, Vec3i{-60, 3, 100}}) {
        EXPECT_NEAR(rank_at(at + Vec3i{kRow, 0, 0}, kInside, 9),
                    rank_at(at - Vec3i{0, 1, 0}, kInside, 9), 1);
        EXPECT_NEAR(rank_at(at + Vec3i{0, kRow, 0}, kInside, 9),
                    rank_at(at + Vec3i{1, 0, 0}, kInside, 9), 1);
    }
}

// The masks determine prints: they must be the same wherever it is built.
TEST(BlueNoise, MasksAreTheSameEverywhere) {
    uint32_t hash = 0;
    for (const BlueNoiseMask* mask : {&kBlueNoiseInside, &kBlueNoiseSides}) {
        for (const auto& ranks : *mask)
            hash = abi::mix32(hash ^ ranks[0]);
    }
    EXPECT_EQ(hash, 3369555396u);
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
    constexpr uint32_t kSeeds = 64;
    for (int32_t fraction : {9, 12, 16}) {
        int32_t printed = 0;
        for (uint32_t seed = 0; seed < kSeeds; ++seed) {
            for (int32_t z = 0; z < 50; ++z) {
                for (int32_t y = 0; y < kRow; ++y) {
                    for (int32_t x = 0; x < kRow; ++x)
                        printed +=
                            reference::blue_noise_threshold({x, y, z}, kInside, seed) < fraction
                                ? 1
                                : 0;
                }
            }
        }
        // Ranks 0 and 1 have the same threshold.
        const double asked = (fraction + 1) / 65536.0 * 50 * kRow * kRow * kSeeds;
        EXPECT_NEAR(printed / asked, 1.0, 0.1) << fraction;
    }
}

// The pattern of a side is the mask, not sections through it: a piece as large as the mask has each
// rank once.
TEST(BlueNoise, SidesHaveTheMaskInTheirPlane) {
    using enum BlueNoiseFace;
    for (const BlueNoiseFace face : {kLowX, kHighX, kLowY, kHighY}) {
        const bool x_side = face == kLowX || face == kHighX;
        const auto turn = static_cast<int32_t>(BlueNoiseOffset(3, face).turn);
        std::vector<int32_t> found;
        for (int32_t z = -30; z < kRow - 30; ++z) {
            for (int32_t i = -7; i < kRow - 7; ++i) {
                const Vec3i voxel = x_side ? Vec3i{5, i, z} : Vec3i{i, 5, z};
                const int32_t rank = rank_at(voxel, face, 3);
                const Vec3i behind = voxel + (x_side ? Vec3i{9, 0, 0} : Vec3i{0, 9, 0});
                ASSERT_NEAR(rank, rank_at(behind, face, 3), 1);
                // Ranks are 16 apart, and known but for 1.
                found.push_back(((rank - turn + 8) & 0xffff) / 16);
            }
        }
        std::sort(found.begin(), found.end());
        EXPECT_LE(kPixels - 16, std::unique(found.begin(), found.end()) - found.begin());
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
