// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Patterns of the dithers' dots: no columns from slice to slice, no worms, no empty first rows.
// Each measure is shown to detect these in Floyd-Steinberg's rule, which has all three.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using dither::DitherRule;

/// Slices of `side` x `side` voxels with `fraction` of material 2 in material 1.
std::vector<uint8_t> mixture(int32_t side, int32_t slices, double fraction, DitherRule rule,
                             uint64_t seed = 3) {
    reference::FractionField field = reference::make_field({side, side, slices}, 2);
    for (size_t v = 0; v < field.fractions.size(); v += 3) {
        field.fractions[v + 2] = static_cast<uint16_t>(std::lround(fraction * 65535));
        field.fractions[v + 1] = static_cast<uint16_t>(65535 - field.fractions[v + 2]);
    }
    return testing::print_field(field, seed, abi::best_isa(), rule);
}

double differing_from_above(double fraction, DitherRule rule) {
    const size_t slice = 64 * 64;
    const std::vector<uint8_t> codes = mixture(64, 64, fraction, rule);
    size_t differ = 0;
    for (size_t i = slice; i < codes.size(); ++i)
        differ += codes[i] != codes[i - slice] ? 1 : 0;
    return static_cast<double>(differ) / static_cast<double>(codes.size() - slice);
}

TEST(DitherPattern, SlicesDoNotRepeat) {
    for (DitherRule rule : {DitherRule::kDecorrelated, DitherRule::kBlueNoise}) {
        const double half = differing_from_above(0.5, rule);
        EXPECT_GE(half, 0.45);
        EXPECT_LE(half, 0.75);
        // Dots of a small fraction lie above each other no more often than by chance.
        EXPECT_GE(differing_from_above(0.02, rule), 0.9 * 2 * 0.02 * 0.98);
        EXPECT_GE(differing_from_above(0.1, rule), 0.9 * 2 * 0.1 * 0.9);
    }
    EXPECT_LT(differing_from_above(0.02, DitherRule::kFloydSteinberg), 0.5 * 2 * 0.02 * 0.98);
}

TEST(DitherPattern, NoColumns) {
    for (DitherRule rule : {DitherRule::kDecorrelated, DitherRule::kBlueNoise}) {
        const std::vector<uint8_t> codes = mixture(128, 64, 0.5, rule);
        int32_t uneven = 0;
        for (size_t column = 0; column < 128 * 128; ++column) {
            int32_t second = 0;
            for (size_t z = 0; z < 64; ++z)
                second += codes[z * 128 * 128 + column] == 2 ? 1 : 0;
            uneven += second > 46 || second < 18 ? 1 : 0;
        }
        EXPECT_LE(uneven, 16) << "rule " << static_cast<int>(rule);  // a thousandth
    }
}

/// A histogram of the directions between dots about one mean distance apart, in 12 sectors of 15
/// degrees.
using Sectors = std::vector<double>;

Sectors directions(double fraction, DitherRule rule, uint64_t seed) {
    const int32_t side = 256;
    const double distance = 1 / std::sqrt(fraction);
    Sectors sectors(12, 0.0);
    const std::vector<uint8_t> codes = mixture(side, 1, fraction, rule, seed);
    std::vector<Vec2<int32_t>> dots;
    for (int32_t y = 0; y < side; ++y) {
        for (int32_t x = 0; x < side; ++x) {
            if (codes[static_cast<size_t>(y) * side + x] == 2) dots.push_back({x, y});
        }
    }
    for (const auto& a : dots) {
        for (const auto& b : dots) {
            // One of the two directions is enough.
            if (b.y < a.y || (b.y == a.y && b.x < a.x)) continue;
            if (b.y > a.y + 1.4 * distance) break;
            const double r = std::hypot(b.x - a.x, b.y - a.y);
            if (r < 0.3 * distance || r > 1.4 * distance) continue;
            const double half_turns = std::atan2(b.y - a.y, b.x - a.x) / std::numbers::pi;
            ++sectors[static_cast<size_t>(std::floor(half_turns * 12 + 24.5)) % 12];
        }
    }
    return sectors;
}

/// The difference between the most and the least frequent one, relative to the mean.
double spread(const Sectors& sectors) {
    const auto [least, most] = std::minmax_element(sectors.begin(), sectors.end());
    return (*most - *least) * 12 / std::accumulate(sectors.begin(), sectors.end(), 0.0);
}

TEST(DitherPattern, NoWorms) {
    struct Bar {
        double fraction;
        uint64_t seeds;
        double each, all;
    };
    // Even white noise has 0.9 at 2 % here. At 0.5 % the blue-noise mask has 18 dots, which repeat,
    // so a single seed says little.
    for (const Bar& bar : {Bar{0.005, 16, 3, 1.8}, Bar{0.02, 16, 1.6, 1.4}, Bar{0.1, 6, 1, 0.9}}) {
        for (DitherRule rule : {DitherRule::kDecorrelated, DitherRule::kBlueNoise}) {
            Sectors all(12, 0.0);
            for (uint64_t seed = 0; seed < bar.seeds; ++seed) {
                const Sectors one = directions(bar.fraction, rule, seed);
                EXPECT_LT(spread(one), bar.each)
                    << bar.fraction << " of rule " << static_cast<int>(rule) << ", seed " << seed;
                for (size_t s = 0; s < all.size(); ++s)
                    all[s] += one[s];
            }
            EXPECT_LT(spread(all), bar.all)
                << bar.fraction << " of rule " << static_cast<int>(rule);
        }
        EXPECT_GT(spread(directions(bar.fraction, DitherRule::kFloydSteinberg, 0)), 1.4 * bar.each);
    }
}

/// Dots in the first quarter of the rows, relative to the requested number.
double first_rows(double fraction, DitherRule rule) {
    const int32_t side = 64;
    const std::vector<uint8_t> codes = mixture(side, side, fraction, rule);
    double dots = 0;
    for (int32_t z = 0; z < side; ++z) {
        for (int32_t i = 0; i < side * side / 4; ++i)
            dots += codes[static_cast<size_t>(z) * side * side + i] == 2 ? 1 : 0;
    }
    return dots / (fraction * side * side / 4 * side);
}

TEST(DitherPattern, BeginsAtOnce) {
    for (DitherRule rule : {DitherRule::kDecorrelated, DitherRule::kBlueNoise}) {
        EXPECT_GT(first_rows(0.005, rule), 0.5);
        EXPECT_GT(first_rows(0.02, rule), 0.8);
    }
    EXPECT_LT(first_rows(0.005, DitherRule::kFloydSteinberg), 0.3);
}

}  // namespace
}  // namespace openfab
