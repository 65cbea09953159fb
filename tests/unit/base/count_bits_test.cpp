// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/count_bits.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace openfab {
namespace {

TEST(CountBits, IsOneByOneOfAnyLengthAndMask) {
    std::mt19937 random(1);
    for (size_t length = 0; length < 40; ++length) {
        for (const unsigned mask : {255u, 0u, 1u, 0x80u, 0x5au}) {
            std::vector<uint8_t> bytes(length);
            int64_t wanted = 0;
            for (uint8_t& byte : bytes) {
                byte = static_cast<uint8_t>(random());
                for (unsigned bit = 1; bit < 256; bit *= 2)
                    wanted += (byte & mask & bit) != 0 ? 1 : 0;
            }
            EXPECT_EQ(count_bits(bytes, static_cast<uint8_t>(mask)), wanted) << length;
        }
        EXPECT_EQ(count_bits(std::vector<uint8_t>(length, 255)), 8 * static_cast<int64_t>(length));
    }
}

}  // namespace
}  // namespace openfab
