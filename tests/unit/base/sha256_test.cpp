// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// SHA-256 against the examples of its standard.

#include "base/sha256.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace openfab::testing {
namespace {

/// Source: FIPS 180-4's examples, NIST, "SHA256.pdf" and "SHA2_Additional.pdf".
TEST(Sha256, ExamplesOfTheStandard) {
    const auto text_of = [](std::string_view text) { return hex_text(sha256(text)); };
    EXPECT_EQ(text_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(text_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(text_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(text_of(std::string(1'000'000, 'a')),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, PiecesOfAnyLengthAreOneStream) {
    std::mt19937 random(1);
    std::vector<uint8_t> bytes(1000);
    for (uint8_t& byte : bytes)
        byte = static_cast<uint8_t>(random());
    const Sha256Digest whole = sha256(std::span<const uint8_t>(bytes));
    for (int round = 0; round < 200; ++round) {
        Sha256 sum;
        for (size_t at = 0; at < bytes.size();) {
            const size_t more = std::min<size_t>(random() % 150, bytes.size() - at);
            sum.add(std::span(bytes).subspan(at, more));
            at += more;
        }
        ASSERT_EQ(sum.digest(), whole);
    }
}

TEST(Sha256, DigitsAreReadBack) {
    Sha256Digest digest{};
    const std::string text = hex_text(sha256("abc"));
    ASSERT_TRUE(parse_hex(text, &digest));
    EXPECT_EQ(digest, sha256("abc"));
    EXPECT_FALSE(parse_hex(text.substr(1), &digest));
    EXPECT_FALSE(parse_hex(text.substr(1) + "g", &digest));
}

}  // namespace
}  // namespace openfab::testing
