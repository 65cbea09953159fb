// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slice_totals.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/reference/pack.h"

namespace openfab::pipeline {
namespace {

TEST(SliceTotals, EqualsACountVoxelByVoxel) {
    std::mt19937 random(5);
    for (int32_t width : {1, 2, 15, 16, 17, 33, 64, 101, 640, 1001}) {
        // Long ones have runs.
        const uint32_t other = width < 200 ? 3 : 300;
        const int32_t height = 7;
        std::vector<uint8_t> data;
        SliceTotals expected;
        for (int32_t y = 0; y < height; ++y) {
            std::vector<uint8_t> codes(static_cast<size_t>(width), 0);
            for (int32_t x = 0; x < width && y > 1 && y < 6; ++x) {
                codes[x] = random() % other == 0 ? static_cast<uint8_t>(random() % 16) : uint8_t{1};
            }
            if (y > 1 && y < 6) codes[0] = 0;
            for (int32_t x = 0; x < width; ++x) {
                const uint8_t code = codes[x];
                ++expected.by_code[code];
                if (code == 0) continue;
                expected.tight.add(Vec3i{x, y, 11});
            }
            const std::vector<uint8_t> row = reference::pack_row(codes);
            data.insert(data.end(), row.begin(), row.end());
        }
        const SliceTotals counted =
            count_slice({11, data.data(), static_cast<size_t>((width + 1) / 2), width, height}, 4);
        EXPECT_EQ(counted.by_code, expected.by_code) << width;
        if (!expected.tight.empty()) expected.tight.hi = expected.tight.hi + Vec3i{1, 1, 1};
        EXPECT_EQ(counted.tight, expected.tight) << width;
    }
}

TEST(SliceTotals, CountsEightBits) {
    const std::vector<uint8_t> data{0, 0, 0, 0, 0, 64, 17, 0, 0, 1, 17, 0};
    const SliceTotals counted = count_slice({5, data.data(), 4, 4, 3}, 8);
    EXPECT_EQ(counted.by_code[0], 8);
    EXPECT_EQ(counted.by_code[1], 1);
    EXPECT_EQ(counted.by_code[17], 2);
    EXPECT_EQ(counted.by_code[64], 1);
    EXPECT_EQ(counted.tight, (Box3i{{1, 1, 5}, {3, 3, 6}}));
}

TEST(SliceTotals, HashSeesContentAndHeight) {
    std::vector<uint8_t> data(64, 0x11);
    const uint64_t hash = count_slice({3, data.data(), 8, 16, 8}, 4).hash;
    EXPECT_EQ(hash, count_slice({3, data.data(), 8, 16, 8}, 4).hash);
    EXPECT_NE(hash, count_slice({4, data.data(), 8, 16, 8}, 4).hash);
    data[63] = 0x12;
    EXPECT_NE(hash, count_slice({3, data.data(), 8, 16, 8}, 4).hash);
}

}  // namespace
}  // namespace openfab::pipeline
