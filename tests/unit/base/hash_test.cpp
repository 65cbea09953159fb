// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
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
            // The value in existing `.ofr` files.
            ASSERT_EQ(xxh3({bytes.data() + from, count}, 0),
                      XXH3_64bits(bytes.data() + from, count));
        }
    }
}

TEST(HashTest, InPiecesAsInOne) {
    std::mt19937 random(6);
    std::vector<uint8_t> bytes(3000);
    for (uint8_t& b : bytes)
        b = static_cast<uint8_t>(random());
    for (const size_t piece : {1, 7, 240, 1024, 3000}) {
        Hasher hasher;
        for (size_t at = 0; at < bytes.size(); at += piece)
            hasher.add_bytes(bytes.data() + at, std::min(piece, bytes.size() - at));
        EXPECT_EQ(hasher.value(), xxh3(bytes, 0)) << piece;
        EXPECT_EQ(hasher.value(), XXH3_64bits(bytes.data(), bytes.size())) << "may be asked twice";
    }
    EXPECT_EQ(Hasher().value(), xxh3(std::string_view()));
}

TEST(HashTest, TextsDoNotRunIntoEachOther) {
    Hasher one, other, plain;
    one.add_text("a"), one.add_text("bc");
    other.add_text("ab"), other.add_text("c");
    EXPECT_NE(one.value(), other.value());
    const char layout[] = {1, 0, 0, 0, 0, 0, 0, 0, 'a', 2, 0, 0, 0, 0, 0, 0, 0, 'b', 'c'};
    plain.add_bytes(layout, sizeof layout);
    EXPECT_EQ(one.value(), plain.value());
}

}  // namespace
}  // namespace openfab
