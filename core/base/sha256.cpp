// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/sha256.h"

#include <algorithm>
#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace openfab {

namespace {

constexpr std::array<uint32_t, 64> kRounds{
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

uint32_t big_endian(const uint8_t* at) {
    return uint32_t{at[0]} << 24 | uint32_t{at[1]} << 16 | uint32_t{at[2]} << 8 | at[3];
}

}  // namespace

namespace sha256_detail {

void add_blocks_plain(uint32_t* state, const uint8_t* blocks, size_t count) {
    for (; count > 0; --count, blocks += 64) {
        std::array<uint32_t, 64> w{};
        for (size_t i = 0; i < 16; ++i)
            w[i] = big_endian(blocks + 4 * i);
        for (size_t i = 16; i < 64; ++i) {
            const uint32_t a = w[i - 15], b = w[i - 2];
            w[i] = w[i - 16] + w[i - 7] + (std::rotr(a, 7) ^ std::rotr(a, 18) ^ (a >> 3)) +
                   (std::rotr(b, 17) ^ std::rotr(b, 19) ^ (b >> 10));
        }
        std::array<uint32_t, 8> s{};
        std::copy_n(state, 8, s.begin());
        for (size_t i = 0; i < 64; ++i) {
            const uint32_t t1 = s[7] +
                                (std::rotr(s[4], 6) ^ std::rotr(s[4], 11) ^ std::rotr(s[4], 25)) +
                                ((s[4] & s[5]) ^ (~s[4] & s[6])) + kRounds[i] + w[i];
            const uint32_t t2 = (std::rotr(s[0], 2) ^ std::rotr(s[0], 13) ^ std::rotr(s[0], 22)) +
                                ((s[0] & s[1]) ^ (s[0] & s[2]) ^ (s[1] & s[2]));
            s = {t1 + t2, s[0], s[1], s[2], s[3] + t1, s[4], s[5], s[6]};
        }
        for (size_t i = 0; i < 8; ++i)
            state[i] += s[i];
    }
}

#if defined(__x86_64__)

namespace {

bool has_instructions() {
    static const bool has = [] {
        unsigned a = 0, b = 0, c = 0, d = 0;
        return __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & (1U << 29)) != 0;
    }();
    return has;
}

/// Two of the processor's steps are four rounds. Its registers hold the words in the order f e b a and h g
/// d c, the lowest first. Source: Intel, SHA Extensions, 2013.
__attribute__((target("sha,sse4.1"))) void add_blocks(uint32_t* state, const uint8_t* blocks,
                                                      size_t count) {
    const __m128i swap = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);
    auto* const to = reinterpret_cast<__m128i*>(state);
    const __m128i dcba = _mm_loadu_si128(to), hgfe = _mm_loadu_si128(to + 1);
    const __m128i cdab = _mm_shuffle_epi32(dcba, 0xb1), efgh = _mm_shuffle_epi32(hgfe, 0x1b);
    __m128i abef = _mm_alignr_epi8(cdab, efgh, 8), cdgh = _mm_blend_epi16(efgh, cdab, 0xf0);
    for (; count > 0; --count, blocks += 64) {
        const __m128i abef_before = abef, cdgh_before = cdgh;
        __m128i w[4];
        for (int i = 0; i < 4; ++i) {
            w[i] = _mm_shuffle_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(blocks) + i),
                                    swap);
        }
        for (int i = 0; i < 16; ++i) {
            const __m128i now = w[i & 3];
            __m128i sum = _mm_add_epi32(
                now, _mm_loadu_si128(reinterpret_cast<const __m128i*>(kRounds.data()) + i));
            cdgh = _mm_sha256rnds2_epu32(cdgh, abef, sum);
            sum = _mm_shuffle_epi32(sum, 0x0e);
            abef = _mm_sha256rnds2_epu32(abef, cdgh, sum);
            if (i >= 12) continue;
            const __m128i last = w[(i + 3) & 3];
            __m128i next = _mm_sha256msg1_epu32(now, w[(i + 1) & 3]);
            next = _mm_add_epi32(next, _mm_alignr_epi8(last, w[(i + 2) & 3], 4));
            w[i & 3] = _mm_sha256msg2_epu32(next, last);
        }
        abef = _mm_add_epi32(abef, abef_before);
        cdgh = _mm_add_epi32(cdgh, cdgh_before);
    }
    const __m128i feba = _mm_shuffle_epi32(abef, 0x1b), dchg = _mm_shuffle_epi32(cdgh, 0xb1);
    _mm_storeu_si128(to, _mm_blend_epi16(feba, dchg, 0xf0));
    _mm_storeu_si128(to + 1, _mm_alignr_epi8(dchg, feba, 8));
}

}  // namespace

bool add_blocks_fast(uint32_t* state, const uint8_t* blocks, size_t count) {
    if (!has_instructions()) return false;
    add_blocks(state, blocks, count);
    return true;
}

#else

bool add_blocks_fast(uint32_t*, const uint8_t*, size_t) {
    return false;
}

#endif

}  // namespace sha256_detail

namespace {

void add_blocks_any(uint32_t* state, const uint8_t* blocks, size_t count) {
    if (!sha256_detail::add_blocks_fast(state, blocks, count))
        sha256_detail::add_blocks_plain(state, blocks, count);
}

}  // namespace

void Sha256::add(std::span<const uint8_t> bytes) {
    const auto waiting = static_cast<size_t>(bytes_ % block_.size());
    bytes_ += bytes.size();
    if (waiting > 0) {
        const size_t taken = std::min(block_.size() - waiting, bytes.size());
        std::copy_n(bytes.begin(), taken, block_.begin() + static_cast<std::ptrdiff_t>(waiting));
        if (waiting + taken < block_.size()) return;
        add_blocks_any(state_.data(), block_.data(), 1);
        bytes = bytes.subspan(taken);
    }
    const size_t whole = bytes.size() / block_.size();
    add_blocks_any(state_.data(), bytes.data(), whole);
    const std::span<const uint8_t> rest = bytes.subspan(whole * block_.size());
    std::copy(rest.begin(), rest.end(), block_.begin());
}

Sha256Digest Sha256::digest() {
    const uint64_t bits = bytes_ * 8;
    std::array<uint8_t, 72> end{0x80};
    // Zeros up to the last eight bytes of a block, which have the length.
    const size_t zeros = (119 - static_cast<size_t>(bytes_ % 64)) % 64;
    for (size_t i = 0; i < 8; ++i)
        end[1 + zeros + i] = static_cast<uint8_t>(bits >> (56 - 8 * i));
    add(std::span(end).first(1 + zeros + 8));
    Sha256Digest out{};
    for (size_t i = 0; i < out.size(); ++i)
        out[i] = static_cast<uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
    return out;
}

Sha256Digest sha256(std::span<const uint8_t> bytes) {
    Sha256 sum;
    sum.add(bytes);
    return sum.digest();
}

Sha256Digest sha256(std::string_view text) {
    return sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string hex_text(const Sha256Digest& digest) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string text;
    for (const uint8_t byte : digest) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15];
    }
    return text;
}

bool parse_hex(std::string_view text, Sha256Digest* digest) {
    if (text.size() != 2 * digest->size()) return false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const int value = c >= '0' && c <= '9'   ? c - '0'
                          : c >= 'a' && c <= 'f' ? c - 'a' + 10
                          : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                 : -1;
        if (value < 0) return false;
        uint8_t& byte = (*digest)[i / 2];
        byte = static_cast<uint8_t>(i % 2 == 0 ? value << 4 : byte | value);
    }
    return true;
}

}  // namespace openfab
