// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Closed forms of the normalise stage, and equal bits with its twin.

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "abi/stages.h"
#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct OneVoxel {
    std::vector<uint16_t> fractions;  ///< of each material
    uint8_t code = 0;
    int32_t unusable = 0;
};

/// Normalises one list of amounts, put in one voxel of the third of four columns.
OneVoxel normalise_one(const std::vector<float>& amounts, const std::vector<int32_t>& slot_material,
                       int32_t materials, openfab_isa isa) {
    const abi::Channels channels(slot_material);
    std::vector<float> weights(32 * amounts.size());
    for (size_t s = 0; s < amounts.size(); ++s)
        weights[32 * s + 19] = amounts[s];
    const int32_t columns[] = {2};
    std::vector<uint16_t> fractions(static_cast<size_t>(8 * channels.count()));
    uint8_t codes[8];
    uint16_t unusable[8];
    EXPECT_TRUE(abi::normalise(isa, columns, channels, weights.data(), 32, fractions.data(), codes,
                               unusable)
                    .ok());
    OneVoxel result;
    result.fractions.resize(static_cast<size_t>(materials + 1));
    for (int32_t c = 0; c < channels.count(); ++c) {
        if (channels.material(c) >= 0)
            result.fractions[channels.material(c)] = fractions[8 * c + 3];
    }
    result.code = codes[3];
    result.unusable = unusable[3];
    for (int z = 0; z < 8; ++z) {
        EXPECT_TRUE(z == 3 || codes[z] == 0) << "a voxel without amounts is void";
        EXPECT_TRUE(z == 3 || unusable[z] == 0);
    }
    return result;
}

using Fractions = std::vector<uint16_t>;

TEST(Normalise, PureIsExactly65535) {
    for (openfab_isa isa : testing::runnable_isas()) {
        for (float w : {1e-38f, 1e-45f, 0.1f, 1.0f, 3.0f, 1e38f, kInf}) {
            const OneVoxel v = normalise_one({0, w}, {1, 2}, 2, isa);
            EXPECT_EQ(v.fractions, (Fractions{0, 0, 65535})) << w;
            EXPECT_EQ(v.code, 2);
            EXPECT_EQ(v.unusable, 0);
        }
    }
}

TEST(Normalise, NothingIsVoid) {
    for (openfab_isa isa : testing::runnable_isas()) {
        const OneVoxel v = normalise_one({0, -0.0f}, {1, 2}, 2, isa);
        EXPECT_EQ(v.fractions, (Fractions{65535, 0, 0}));
        EXPECT_EQ(v.code, 0);
        EXPECT_EQ(v.unusable, 0);
    }
}

TEST(Normalise, NegativeAndNanCountAsNothingAndAreCounted) {
    for (openfab_isa isa : testing::runnable_isas()) {
        const OneVoxel v = normalise_one({-1, kNan, 2, -kInf}, {1, 2, 2, 1}, 2, isa);
        EXPECT_EQ(v.fractions, (Fractions{0, 0, 65535}));
        EXPECT_EQ(v.unusable, 3);
    }
}

TEST(Normalise, SlotsOfOneMaterialAddUp) {
    for (openfab_isa isa : testing::runnable_isas()) {
        const OneVoxel v = normalise_one({1, 1, 2}, {1, 2, 1}, 2, isa);
        EXPECT_EQ(v.fractions,
                  (Fractions{0, 49151, 16384}));  // 3/4 rounds up and gives the remainder back
        EXPECT_EQ(v.code, OPENFAB_CODE_MIXED);
    }
}

TEST(Normalise, VoidTakesPartInTheMixture) {
    for (openfab_isa isa : testing::runnable_isas()) {
        EXPECT_EQ(normalise_one({1, 1}, {0, 1}, 1, isa).fractions, (Fractions{32767, 32768}));
        EXPECT_EQ(normalise_one({1, 1}, {0, 1}, 1, isa).code, OPENFAB_CODE_MIXED);
    }
}

TEST(Normalise, RemainderGoesToTheLargestFirstOfEquals) {
    for (openfab_isa isa : testing::runnable_isas()) {
        // Three thirds round to 21845 and leave nothing; two halves round up to 32768 each, one too
        // many.
        EXPECT_EQ(normalise_one({1, 1, 1}, {1, 2, 3}, 3, isa).fractions,
                  (Fractions{0, 21845, 21845, 21845}));
        EXPECT_EQ(normalise_one({1, 1}, {1, 2}, 2, isa).fractions, (Fractions{0, 32767, 32768}));
    }
}

TEST(Normalise, HugeAmountsDoNotOverflow) {
    for (openfab_isa isa : testing::runnable_isas()) {
        EXPECT_EQ(normalise_one({3e38f, 3e38f, 3e38f}, {1, 2, 2}, 2, isa).fractions,
                  (Fractions{0, 21845, 43690}));
        EXPECT_EQ(normalise_one({kInf, 3e38f, kInf}, {1, 2, 3}, 3, isa).fractions,
                  (Fractions{0, 32767, 0, 32768}));
    }
}

TEST(Normalise, SameBitsAsTheTwin) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    const float odd[] = {0, -0.0f, -1, kNan, kInf, -kInf, 1e-45f, 3e38f, 1.7e38f, 1};
    for (int32_t materials : {1, 2, 3, 4, 6, 8, 12, 15, 40}) {
        for (openfab_isa isa : testing::runnable_isas()) {
            const auto slots = static_cast<size_t>(materials + 2);
            constexpr size_t kColumns = 60;
            std::vector<int32_t> slot_material;
            for (size_t s = 0; s < slots; ++s)
                slot_material.push_back(static_cast<int32_t>(random() % (materials + 1)));
            const abi::Channels channels(slot_material);
            std::vector<float> weights(8 * kColumns * slots);
            for (float& w : weights)
                w = random() % 4 == 0 ? odd[random() % 10] : unit(random);
            std::vector<int32_t> columns;
            for (size_t i = 0; i < kColumns; ++i)
                columns.push_back(static_cast<int32_t>(random() % kColumns));
            const auto count = static_cast<size_t>(channels.count());
            std::vector<uint16_t> fractions(8 * count * kColumns), unusable(8 * kColumns);
            std::vector<uint8_t> codes(8 * kColumns);
            ASSERT_TRUE(abi::normalise(isa, columns, channels, weights.data(), 8 * kColumns,
                                       fractions.data(), codes.data(), unusable.data())
                            .ok());
            for (size_t v = 0; v < 8 * kColumns; ++v) {
                const size_t voxel = static_cast<size_t>(8 * columns[v / 8]) + v % 8;
                std::vector<float> amounts;
                for (size_t s = 0; s < slots; ++s)
                    amounts.push_back(weights[s * 8 * kColumns + voxel]);
                int64_t expected_count = 0;
                const std::vector<uint16_t> expected =
                    reference::normalise(amounts, slot_material, materials, &expected_count);
                ASSERT_EQ(unusable[v], expected_count);
                for (int32_t c = 0; c < channels.count(); ++c) {
                    const int32_t m = channels.material(c);
                    if (m < 0) continue;
                    ASSERT_EQ(fractions[(v / 8 * count + static_cast<size_t>(c)) * 8 + v % 8],
                              expected[m])
                        << materials << " materials, voxel " << voxel << ", material " << m;
                }
            }
        }
    }
}

}  // namespace
}  // namespace openfab
