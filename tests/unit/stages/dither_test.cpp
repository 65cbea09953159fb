// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The dithers and the rows of blocks around them against the textbook twins, bit for bit.

#include <gtest/gtest.h>

#include <random>

#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using dither::DitherRule;
using reference::FractionField;

constexpr DitherRule kRules[] = {DitherRule::kFloydSteinberg, DitherRule::kDecorrelated,
                                 DitherRule::kBlueNoise, DitherRule::kMajority};

enum class Kind { kAllMixed, kPatches, kSpeckle, kThinWalls };

void set_mixture(uint16_t* f, int32_t channels, std::mt19937& random) {
    int32_t left = 65535;
    for (int32_t m = 0; m < channels; ++m) {
        const int32_t share = random() % 3 == 0 ? 0 : static_cast<int32_t>(random() % (left + 1));
        f[m] = static_cast<uint16_t>(share);
        left -= share;
    }
    const auto rest = static_cast<size_t>(random() % channels);
    f[rest] = static_cast<uint16_t>(f[rest] + left);
}

void set_pure(uint16_t* f, int32_t channels, uint32_t m) {
    std::fill_n(f, channels, uint16_t{0});
    f[m] = 65535;
}

// A pseudo-random choice for each cube of voxels, so that regions cross the borders of blocks.
uint32_t region(int32_t x, int32_t y, int32_t z) {
    return (static_cast<uint32_t>(x / 5) * 73856093u ^ static_cast<uint32_t>(y / 3) * 19349663u ^
            static_cast<uint32_t>(z / 2) * 83492791u) >>
           4;
}

FractionField random_field(const Vec3i& size, int32_t materials, Kind kind, uint32_t seed) {
    std::mt19937 random(seed);
    FractionField field = reference::make_field(size, materials);
    for (int32_t z = 0; z < size.z; ++z) {
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                uint16_t* f = field.at(x, y, z);
                const uint32_t r = region(x, y, z);
                const bool mixed = kind == Kind::kAllMixed ||
                                   (kind == Kind::kPatches && r % 3 != 0) ||
                                   (kind == Kind::kSpeckle && random() % 4 == 0) ||
                                   (kind == Kind::kThinWalls && (x + 2 * y + z) % 13 < 2);
                if (mixed) {
                    set_mixture(f, field.channels, random);
                } else {
                    set_pure(f, field.channels, r % static_cast<uint32_t>(field.channels));
                }
            }
        }
    }
    return field;
}

void expect_same(const FractionField& field, uint64_t seed, DitherRule rule) {
    const std::vector<uint8_t> expected = reference::dither(field, seed, rule);
    for (openfab_isa isa : testing::runnable_isas()) {
        const std::vector<uint8_t> printed = testing::print_field(field, seed, isa, rule);
        ASSERT_EQ(printed.size(), expected.size());
        for (size_t i = 0; i < expected.size(); ++i) {
            const auto x = static_cast<int64_t>(i) % field.size.x,
                       y = static_cast<int64_t>(i) / field.size.x % field.size.y;
            ASSERT_EQ(printed[i], expected[i])
                << "rule " << static_cast<int>(rule) << " isa " << isa << " voxel " << x << " " << y
                << " " << static_cast<int64_t>(i) / field.size.x / field.size.y;
        }
    }
}

TEST(Dither, SameBitsAsTheTwin) {
    uint32_t seed = 1;
    for (int32_t materials : {1, 2, 3, 4, 6, 8, 12, 15}) {
        for (Kind kind : {Kind::kAllMixed, Kind::kPatches, Kind::kSpeckle, Kind::kThinWalls}) {
            const FractionField field = random_field({53, 41, 11}, materials, kind, ++seed);
            for (DitherRule rule : kRules)
                expect_same(field, seed, rule);
        }
    }
}

TEST(Dither, SameBitsAsTheTwinForManyMaterials) {
    uint32_t seed = 100;
    for (int32_t materials : {24, 32, 64, 254}) {
        for (Kind kind : {Kind::kAllMixed, Kind::kPatches, Kind::kSpeckle, Kind::kThinWalls}) {
            const FractionField field = random_field({37, 19, 9}, materials, kind, ++seed);
            for (DitherRule rule : kRules)
                expect_same(field, seed, rule);
        }
    }
}

TEST(Dither, SameBitsAsTheTwinForEverySmallSize) {
    for (const Vec3i& size : {Vec3i{1, 1, 1}, Vec3i{1, 9, 1}, Vec3i{9, 1, 3}, Vec3i{8, 8, 8},
                              Vec3i{16, 17, 9}, Vec3i{7, 24, 8}}) {
        for (DitherRule rule : kRules) {
            expect_same(random_field(size, 2, Kind::kAllMixed, 5), 99, rule);
            expect_same(random_field(size, 3, Kind::kPatches, 6), 99, rule);
        }
    }
}

TEST(Dither, HashSeesThePlaceInTheGrid) {
    FractionField field = random_field({40, 24, 8}, 2, Kind::kSpeckle, 3);
    field.origin.z = 64;
    FractionField low = field;
    low.origin.z = 0;
    for (DitherRule rule : kRules) {
        expect_same(field, 1, rule);
        const std::vector<uint8_t> codes = reference::dither(field, 1, rule);
        const bool random = rule != DitherRule::kMajority;
        EXPECT_EQ(codes != reference::dither(low, 1, rule), random);
        EXPECT_EQ(codes != reference::dither(field, uint64_t{1} << 40, rule), random);
    }
}

TEST(Dither, AbsentMaterialIsNeverChosenAndPureStays) {
    for (Kind kind : {Kind::kAllMixed, Kind::kPatches, Kind::kSpeckle, Kind::kThinWalls}) {
        const FractionField field = random_field({64, 64, 16}, 4, kind, 11);
        for (DitherRule rule : kRules) {
            const std::vector<uint8_t> printed =
                testing::print_field(field, 5, abi::best_isa(), rule);
            for (size_t i = 0; i < printed.size(); ++i) {
                ASSERT_GT(field.fractions[i * static_cast<size_t>(field.channels) + printed[i]], 0);
            }
        }
    }
}

TEST(Dither, SlicesShareNoState) {
    const FractionField field = random_field({48, 40, 8}, 3, Kind::kPatches, 21);
    FractionField changed = field;
    for (int32_t y = 0; y < field.size.y; ++y) {
        for (int32_t x = 0; x < field.size.x; ++x)
            set_pure(changed.at(x, y, 3), changed.channels, 1);
    }
    for (DitherRule rule : kRules) {
        std::vector<uint8_t> a = testing::print_field(field, 5, abi::best_isa(), rule);
        std::vector<uint8_t> b = testing::print_field(changed, 5, abi::best_isa(), rule);
        const size_t slice = 48 * 40;
        for (size_t z = 0; z < 8; ++z) {
            const bool same = std::equal(&a[z * slice], &a[z * slice] + slice, &b[z * slice]);
            EXPECT_EQ(same, z != 3) << "slice " << z;
        }
    }
}

}  // namespace
}  // namespace openfab
