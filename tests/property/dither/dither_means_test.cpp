// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The dither prints what is asked for: in bulk, and in layers only a few voxels thick.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using reference::FractionField;

void set_tint(uint16_t* f, double fraction) {
    f[2] = static_cast<uint16_t>(std::lround(fraction * 65535));
    f[1] = static_cast<uint16_t>(65535 - f[2]);
}

/// Share of material 2 among the voxels of `field` that may hold it.
double printed_share(const FractionField& field, uint64_t seed) {
    const std::vector<uint8_t> codes = tests::print_field(field, seed, abi::best_isa());
    int64_t asked = 0, printed = 0;
    for (size_t i = 0; i < codes.size(); ++i) {
        if (field.fractions[i * 3 + 2] == 0) continue;
        ++asked;
        printed += codes[i] == 2 ? 1 : 0;
    }
    return static_cast<double>(printed) / static_cast<double>(asked);
}

TEST(DitherMeans, BulkIsWithinATenthOfAPoint) {
    for (double fraction : {0.005, 0.02, 0.1, 1.0 / 3, 0.5, 0.7, 0.98}) {
        FractionField field = reference::make_field({64, 64, 64}, 2);
        for (size_t v = 0; v < 64 * 64 * 64; ++v)
            set_tint(&field.fractions[v * 3], fraction);
        EXPECT_NEAR(printed_share(field, 1), fraction, 0.001) << fraction;
    }
}

// A layer of the mixture in void (outside 0) or in pure material 1 (outside 1): t voxels thick
// along an axis, or across the diagonal of x and y.
double layer_share(int32_t axis, int32_t thickness, double fraction, uint16_t outside) {
    const int32_t n = 96;
    FractionField field = reference::make_field({n, n, n}, 2);
    for (int32_t z = 0; z < n; ++z) {
        for (int32_t y = 0; y < n; ++y) {
            for (int32_t x = 0; x < n; ++x) {
                const int32_t along = axis == 0 ? x : axis == 1 ? y : axis == 2 ? z : x + y - n / 2;
                uint16_t* f = field.at(x, y, z);
                if (along >= 43 && along < 43 + thickness) {
                    set_tint(f, fraction);
                } else {
                    f[outside] = 65535;
                }
            }
        }
    }
    return printed_share(field, 7);
}

TEST(DitherMeans, ThinLayersAreWithinATenthOfTheFraction) {
    for (uint16_t outside : {uint16_t{0}, uint16_t{1}}) {
        for (int32_t axis = 0; axis < 4; ++axis) {
            for (int32_t thickness : {1, 2, 3, 5}) {
                for (double fraction : {0.02, 0.05, 0.25, 0.5}) {
                    const double share = layer_share(axis, thickness, fraction, outside);
                    EXPECT_NEAR(share / fraction, 1.0, 0.1)
                        << "axis " << axis << ", " << thickness << " thick, " << fraction
                        << ", outside " << outside;
                }
            }
        }
    }
}

}  // namespace
}  // namespace openfab
