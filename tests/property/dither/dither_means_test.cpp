// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The dithers print the requested fractions: in bulk, and in layers only a few voxels thick.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using dither::DitherRule;
using reference::FractionField;

constexpr DitherRule kFloydSteinberg = DitherRule::kFloydSteinberg;
constexpr DitherRule kDecorrelated = DitherRule::kDecorrelated;
constexpr DitherRule kBlueNoise = DitherRule::kBlueNoise;

std::vector<uint16_t> quantised(const std::vector<double>& shares) {
    std::vector<uint16_t> fractions(shares.size() + 1, 0);
    int32_t left = 65535;
    for (size_t m = 1; m < shares.size(); ++m) {
        fractions[m + 1] = static_cast<uint16_t>(std::lround(shares[m] * 65535));
        left -= fractions[m + 1];
    }
    fractions[1] = static_cast<uint16_t>(left);
    return fractions;
}

/// Returns the printed fractions of materials 1, 2, … of one mixture in 64 x 64 x 64 voxels.
std::vector<double> bulk_shares(const std::vector<double>& shares, DitherRule rule) {
    const auto materials = static_cast<int32_t>(shares.size());
    FractionField field = reference::make_field({64, 64, 64}, materials);
    const std::vector<uint16_t> mixture = quantised(shares);
    for (size_t v = 0; v < 64 * 64 * 64; ++v)
        std::copy(mixture.begin(), mixture.end(), &field.fractions[v * mixture.size()]);
    std::vector<double> printed(shares.size(), 0.0);
    for (uint8_t code : testing::print_field(field, 1, abi::best_isa(), rule))
        printed[code - 1u] += 1.0 / (64 * 64 * 64);
    return printed;
}

void expect_bulk(const std::vector<double>& shares, DitherRule rule) {
    const std::vector<double> printed = bulk_shares(shares, rule);
    for (size_t m = 0; m < shares.size(); ++m) {
        EXPECT_NEAR(printed[m], shares[m], 0.001) << "rule " << static_cast<int>(rule);
        EXPECT_NEAR(printed[m] / shares[m], 1, 0.1)
            << "rule " << static_cast<int>(rule) << ", " << shares[m] << " among " << shares.size();
    }
}

TEST(DitherMeans, BulkIsWithinATenthOfAPoint) {
    for (DitherRule rule : {kFloydSteinberg, kDecorrelated, kBlueNoise}) {
        for (double fraction : {0.005, 0.01, 0.02, 0.1, 1.0 / 3, 0.5, 0.7, 0.98, 0.995})
            expect_bulk({1 - fraction, fraction}, rule);
    }
}

TEST(DitherMeans, BulkOfMoreMaterials) {
    for (DitherRule rule : {kFloydSteinberg, kDecorrelated, kBlueNoise}) {
        expect_bulk({0.5, 0.005, 0.495}, rule);
        expect_bulk({0.005, 0.9, 0.095}, rule);
        expect_bulk({0.94, 0.02, 0.02, 0.02}, rule);
        expect_bulk({0.985, 0.005, 0.005, 0.005}, rule);
        expect_bulk({0.4, 0.3, 0.2, 0.05, 0.03, 0.02}, rule);
        expect_bulk({.05, .02, .02, .02, .05, .07, .07, .1, .1, .1, .1, .1, .1, .05, .05}, rule);
    }
}

// A layer of the mixture in void (outside 0) or in pure material 1 (outside 1), t voxels thick:
// along x, y, z and across six diagonals.
double layer_share(int32_t n, int32_t axis, int32_t thickness, double fraction, uint16_t outside,
                   DitherRule rule) {
    constexpr Vec3i kNormal[] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0}, {1, -1, 0},
                                 {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    const Vec3i normal = kNormal[axis];
    // The diagonals' layers pass near the middle.
    const int32_t first = axis < 3 ? 29 : normal.x + normal.y + normal.z == 0 ? -3 : n - 5;
    const std::vector<uint16_t> mixture = quantised({1 - fraction, fraction});
    FractionField field = reference::make_field({n, n, n}, 2);
    int64_t asked = 0;
    for (int32_t z = 0; z < n; ++z) {
        for (int32_t y = 0; y < n; ++y) {
            for (int32_t x = 0; x < n; ++x) {
                const int32_t along = x * normal.x + y * normal.y + z * normal.z;
                uint16_t* f = field.at(x, y, z);
                if (along >= first && along < first + thickness) {
                    std::copy(mixture.begin(), mixture.end(), f);
                    ++asked;
                } else {
                    f[outside] = 65535;
                }
            }
        }
    }
    int64_t printed = 0;
    for (uint8_t code : testing::print_field(field, 7, abi::best_isa(), rule))
        printed += code == 2 ? 1 : 0;
    return static_cast<double>(printed) / static_cast<double>(asked);
}

void expect_layers(int32_t n, int32_t axes, DitherRule rule) {
    for (uint16_t outside : {uint16_t{0}, uint16_t{1}}) {
        for (int32_t axis = 0; axis < axes; ++axis) {
            for (int32_t thickness : {1, 2, 3, 5}) {
                for (double fraction : {0.02, 0.05, 0.25, 0.5}) {
                    const double share = layer_share(n, axis, thickness, fraction, outside, rule);
                    EXPECT_NEAR(share / fraction, 1.0, 0.1)
                        << "axis " << axis << ", " << thickness << " thick, " << fraction
                        << ", outside " << outside;
                }
            }
        }
    }
}

// Chains of the 1976 rule begin in the same phase everywhere: it prints 1 of 64 voxels instead of
// 1.28.
TEST(DitherMeans, ThinLayersOfFloydSteinberg) {
    expect_layers(96, 4, kFloydSteinberg);
}
TEST(DitherMeans, ThinLayersOfDecorrelated) {
    expect_layers(64, 9, kDecorrelated);
}
TEST(DitherMeans, ThinLayersOfBlueNoise) {
    expect_layers(64, 9, kBlueNoise);
}

}  // namespace
}  // namespace openfab
