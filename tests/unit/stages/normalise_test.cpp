// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Closed forms of the normalise stage, and equal bits with its twin.

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "abi/stages.h"
#include "base/infinity.h"
#include "tests/support/reference/dither.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Normalises one list of amounts, replicated in every voxel of a block.
struct OneVoxel {
    std::vector<uint16_t> fractions;
    uint8_t code = 0;
    int32_t unusable = 0;  ///< in the slice
};

OneVoxel normalise_one(const std::vector<float>& amounts, const std::vector<int32_t>& slot_material,
                       int32_t materials, openfab_isa isa) {
    abi::StageCalls calls(*abi::find_stage_set(materials), isa);
    std::vector<float> weights(512 * amounts.size());
    for (size_t s = 0; s < amounts.size(); ++s)
        std::fill_n(&weights[512 * s], 512, amounts[s]);
    std::vector<uint8_t> owned(64, 0);
    owned[9] = 1 << 3;  // one voxel: x = 1, y = 1, z = 3
    std::vector<uint16_t> fractions(static_cast<size_t>(calls.tile_values()));
    uint8_t codes[512];
    int32_t unusable[8];
    EXPECT_TRUE(calls
                    .normalise(weights.data(), static_cast<int32_t>(amounts.size()),
                               slot_material.data(), owned.data(), 1, fractions.data(), codes,
                               unusable)
                    .ok());
    OneVoxel result;
    for (int32_t m = 0; m < calls.channels(); ++m) {
        result.fractions.push_back(
            fractions[static_cast<size_t>((9 * calls.channels() + m) * 8 + 3)]);
    }
    result.code = codes[9 * 8 + 3];
    result.unusable = unusable[3];
    for (int v = 0; v < 512; ++v) {
        EXPECT_TRUE(v == 9 * 8 + 3 || codes[v] == 0) << "voxel " << v << " is not owned";
    }
    for (int z = 0; z < 8; ++z) {
        EXPECT_TRUE(z == 3 || unusable[z] == 0);
    }
    return result;
}

using Fractions = std::vector<uint16_t>;

TEST(Normalise, PureIsExactly65535) {
    for (openfab_isa isa : testing::runnable_isas()) {
        for (float w : {1e-38f, 1e-45f, 0.1f, 1.0f, 3.0f, 1e38f, kInfinity}) {
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
        const OneVoxel v = normalise_one({-1, kNan, 2, -kInfinity}, {1, 2, 2, 1}, 2, isa);
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
        // Three thirds round to 21845 without remainder; two halves round up to 32768 each, one too
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
        EXPECT_EQ(normalise_one({kInfinity, 3e38f, kInfinity}, {1, 2, 3}, 3, isa).fractions,
                  (Fractions{0, 32767, 0, 32768}));
    }
}

TEST(Normalise, SameBitsAsTheTwin) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, 1);
    const float odd[] = {0, -0.0f, -1, kNan, kInfinity, -kInfinity, 1e-45f, 3e38f, 1.7e38f, 1};
    for (int32_t materials : {1, 2, 3, 4, 6, 8, 12, 15}) {
        for (openfab_isa isa : testing::runnable_isas()) {
            abi::StageCalls calls(*abi::find_stage_set(materials), isa);
            const int32_t slots = materials + 2, n = 3;
            std::vector<int32_t> slot_material;
            for (int32_t s = 0; s < slots; ++s)
                slot_material.push_back(static_cast<int32_t>(random() % (materials + 1)));
            std::vector<float> weights(static_cast<size_t>(512) * slots * n);
            for (float& w : weights)
                w = random() % 4 == 0 ? odd[random() % 10] : unit(random);
            std::vector<uint8_t> owned(64 * n);
            for (uint8_t& o : owned)
                o = static_cast<uint8_t>(random());
            std::vector<uint16_t> fractions(static_cast<size_t>(calls.tile_values()) * n);
            std::vector<uint8_t> codes(512 * n);
            std::vector<int32_t> unusable(8 * n);
            ASSERT_TRUE(calls
                            .normalise(weights.data(), slots, slot_material.data(), owned.data(), n,
                                       fractions.data(), codes.data(), unusable.data())
                            .ok());
            int64_t counted = 0, expected_count = 0;
            for (int32_t c : unusable)
                counted += c;
            for (int32_t v = 0; v < 512 * n; ++v) {
                const int32_t block = v / 512, voxel = v % 512;
                const bool is_owned = owned[static_cast<size_t>(v / 8)] >> (v % 8) & 1;
                std::vector<float> amounts;
                for (int32_t s = 0; s < slots; ++s)
                    amounts.push_back(weights[(block * slots + s) * 512 + voxel]);
                const std::vector<uint16_t> expected = reference::normalise(
                    amounts, slot_material, materials, is_owned ? &expected_count : nullptr);
                for (int32_t m = 0; m <= materials; ++m) {
                    ASSERT_EQ(fractions[(v / 8 * (materials + 1) + m) * 8 + v % 8], expected[m])
                        << materials << " materials, voxel " << v << ", material " << m;
                }
            }
            EXPECT_EQ(counted, expected_count);
        }
    }
}

}  // namespace
}  // namespace openfab
