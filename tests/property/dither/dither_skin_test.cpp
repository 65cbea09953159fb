// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The visible part of a print is its outermost layer: the default rule prints the right fraction in
// every face, edge and thin feature.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/support/stages/dither_shapes.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using dither::DitherRule;
using dither::kDefaultDither;
using reference::FractionField;
using testing::quantised;

constexpr double kFractions[] = {0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9};
constexpr uint64_t kSeeds[] = {0, 1, 2};

/// Half a point, or 5 % of the fraction.
double allowed(double fraction) {
    return std::max(0.005, 0.05 * fraction);
}

std::vector<uint8_t> print(const FractionField& field, uint64_t seed,
                           DitherRule rule = kDefaultDither) {
    return testing::print_field(field, seed, abi::best_isa(), rule);
}

TEST(DitherSkin, EveryFaceOfABoxHasItsShare) {
    for (double fraction : kFractions) {
        for (const Vec3i& size : {Vec3i{80, 80, 60}, Vec3i{61, 90, 70}}) {
            const FractionField field = testing::box(size, quantised({fraction}));
            for (uint64_t seed : kSeeds) {
                const std::vector<uint8_t> codes = print(field, seed);
                for (int32_t depth : {0, 1, 2}) {
                    const auto shares = testing::face_shares(field, codes, 2, depth);
                    for (size_t face = 0; face < shares.size(); ++face)
                        EXPECT_NEAR(shares[face], fraction, allowed(fraction))
                            << "face " << face << ", depth " << depth << ", seed " << seed;
                }
            }
        }
    }
}

TEST(DitherSkin, EveryMaterialOfAFaceHasItsShare) {
    const std::vector<double> shares{0.3, 0.05, 0.13};
    const FractionField field = testing::box({80, 80, 60}, quantised({0.3, 0.05, 0.13}));
    const std::vector<uint8_t> codes = print(field, 0);
    for (size_t m = 0; m < shares.size(); ++m) {
        for (double share : testing::face_shares(field, codes, static_cast<uint8_t>(m + 2)))
            EXPECT_NEAR(share, shares[m], allowed(shares[m])) << "material " << m + 2;
    }
}

/// A check of the measure: error diffusion leaves the sides where it starts empty.
TEST(DitherSkin, ErrorDiffusionHasNone) {
    const FractionField field = testing::box({80, 80, 60}, quantised({0.1}));
    for (DitherRule rule : {DitherRule::kFloydSteinberg, DitherRule::kDecorrelated}) {
        const auto shares = testing::face_shares(field, print(field, 0, rule), 2);
        EXPECT_LT(shares[0], 0.05);
        EXPECT_LT(shares[2], 0.05);
    }
}

TEST(DitherSkin, EveryOctantOfABallHasItsShare) {
    for (double fraction : kFractions) {
        const FractionField field = testing::ball(50, quantised({fraction}));
        double squares = 0;
        for (uint64_t seed = 0; seed < 8; ++seed) {
            for (double share : testing::skin_shares(field, print(field, seed), 2)) {
                // 3,200 voxels per octant: for 10 %, white noise alone would err by half a point,
                // root mean square. With other seeds a single octant may fail.
                EXPECT_NEAR(share, fraction, allowed(fraction)) << "seed " << seed;
                squares += (share - fraction) * (share - fraction) / 64;
            }
        }
        EXPECT_LT(std::sqrt(squares), 0.45 * allowed(fraction)) << fraction;
    }
}

TEST(DitherSkin, EdgesOfABoxHaveTheirShare) {
    for (double fraction : kFractions) {
        for (int32_t axis = 0; axis < 3; ++axis) {
            const Vec3i size{axis == 0 ? 488 : 12, axis == 1 ? 488 : 12, axis == 2 ? 488 : 12};
            const FractionField field = testing::box(size, quantised({fraction}));
            const auto at_edge = [](int32_t i) { return i == 0 || i == 11; };
            const auto on_edge = [&](const Vec3i& v) {
                const int32_t sides = (at_edge(v.x) && axis != 0 ? 1 : 0) +
                                      (at_edge(v.y) && axis != 1 ? 1 : 0) +
                                      (at_edge(v.z) && axis != 2 ? 1 : 0);
                return sides == 2;
            };
            EXPECT_NEAR(testing::share_of(field, print(field, 0), 2, on_edge), fraction,
                        allowed(fraction))
                << "axis " << axis;
        }
    }
}

/// Returns the printed share in a rod, relative to the requested one.
double rod(int32_t width, int32_t length, int32_t axis, double fraction, uint64_t seed,
           DitherRule rule = kDefaultDither) {
    const Vec3i size{axis == 0 ? length : width, axis == 1 ? length : width,
                     axis == 2 ? length : width};
    const FractionField field = testing::box(size, quantised({fraction}));
    return testing::share_of(field, print(field, seed, rule), 2,
                             [](const Vec3i&) { return true; }) /
           fraction;
}

TEST(DitherSkin, RodsHaveTheirShare) {
    for (int32_t axis = 0; axis < 3; ++axis) {
        for (double fraction : kFractions) {
            for (uint64_t seed : kSeeds) {
                // Long ones, since 1 % of 8 x 8 x 64 is 41 voxels.
                EXPECT_NEAR(rod(8, 488, axis, fraction, seed), 1, 0.05)
                    << fraction << ", axis " << axis << ", seed " << seed;
                if (fraction >= 0.1) {
                    EXPECT_NEAR(rod(8, 64, axis, fraction, seed), 1, 0.05)
                        << fraction << ", axis " << axis << ", seed " << seed;
                }
            }
            for (int32_t width : {3, 4, 5, 6, 11, 16}) {
                const double spread = 1.2 * std::sqrt((1 - fraction) / fraction / 488) / width;
                EXPECT_NEAR(rod(width, 488, axis, fraction, 0), 1, std::max(0.02, spread))
                    << fraction << ", axis " << axis << ", " << width << " wide";
            }
        }
    }
    EXPECT_GT(rod(8, 488, 2, 0.01, 0, DitherRule::kDecorrelated), 1.1);
}

/// Of short rods, too, as a whole: the root mean square over seeds and axes, relative to the share.
TEST(DitherSkin, ShortRodsHaveTheirShare) {
    const auto deviation = [](double fraction, DitherRule rule) {
        double squares = 0;
        for (uint64_t seed = 0; seed < 64; ++seed) {
            for (int32_t axis = 0; axis < 3; ++axis) {
                const double error = rod(8, 64, axis, fraction, seed, rule) - 1;
                squares += error * error / (3 * 64);
            }
        }
        return std::sqrt(squares);
    };
    EXPECT_LT(deviation(0.01, kDefaultDither), 0.05);
    EXPECT_LT(deviation(0.02, kDefaultDither), 0.035);
    EXPECT_LT(deviation(0.05, kDefaultDither), 0.02);
    EXPECT_GT(deviation(0.01, DitherRule::kDecorrelated), 0.1);
}

/// By position in the cross-section of a rod: 61 slices, where error diffusion printed 6 to 54 % of
/// 30 %.
TEST(DitherSkin, RodsHaveTheirShareEverywhereInTheirSection) {
    for (int32_t width : {3, 4, 6, 8}) {
        const FractionField field = testing::box({width, width, 488}, quantised({0.3}));
        const std::vector<uint8_t> codes = print(field, 0);
        for (int32_t y = 0; y < width; ++y) {
            for (int32_t x = 0; x < width; ++x) {
                const auto column = [&](const Vec3i& v) { return v.x == x && v.y == y; };
                EXPECT_NEAR(testing::share_of(field, codes, 2, column), 0.3, 0.03)
                    << x << " " << y << " of " << width;
            }
        }
    }
}

}  // namespace
}  // namespace openfab
