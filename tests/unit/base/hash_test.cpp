// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/hash.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace openfab {
namespace {

TEST(HashTest, IsTheLibrarysWhateverTheVectors) {
    std::mt19937 random(5);
    std::vector<uint8_t> bytes(5000);
    for (uint8_t& b : bytes)
        b = static_cast<uint8_t>(random());
    for (const size_t from : {0, 1, 7}) {
        for (size_t count = 0; from + count <= bytes.size(); count += count < 600 ? 1 : 97) {
            for (const uint64_t seed : {uint64_t{0}, uint64_t{17}, ~uint64_t{0}}) {
                ASSERT_EQ(xxh3({bytes.data() + from, count}, seed),
                          XXH3_64bits_withSeed(bytes.data() + from, count, seed))
                    << count << " bytes from " << from;
            }
            // What `.ofr` files of before have.
            ASSERT_EQ(xxh3({bytes.data() + from, count}, 0),
                      XXH3_64bits(bytes.data() + from, count));
        }
    }
}

}  // namespace
}  // namespace openfab
