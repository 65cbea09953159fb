// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lists of the lanes of a mask, given as bits.

#include <cstdint>

#include "simd/intrinsics.h"
#include "simd/target.h"

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

/// Writes first + l for each lane l of the mask, in order; returns their number. May write up to
/// `lanes` values.
template <int lanes>
OPENFAB_INLINE uint32_t list_lanes(uint32_t mask, uint32_t first, uint32_t* out) {
#if defined(__AVX512F__)
    if constexpr (lanes == 16) {
        const __m512i numbers = _mm512_add_epi32(
            _mm512_set1_epi32(static_cast<int>(first)),
            _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0));
        _mm512_storeu_si512(out,
                            _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), numbers));
        return static_cast<uint32_t>(__builtin_popcount(mask));
    }
#endif
    uint32_t count = 0;
    for (int l = 0; l < lanes; ++l) {
        out[count] = first + static_cast<uint32_t>(l);
        count += mask >> l & 1u;
    }
    return count;
}

/// Writes numbers[l] for each lane l of the mask, in order; returns their number. `numbers` are 16,
/// aligned to 64 bytes; may write up to 16 values.
OPENFAB_INLINE uint32_t list_numbers(uint32_t mask, const uint32_t* numbers, uint32_t* out) {
#if defined(__AVX512F__)
    const __m512i from = _mm512_load_si512(numbers);
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), from));
    return static_cast<uint32_t>(__builtin_popcount(mask));
#else
    uint32_t count = 0;
    for (; mask != 0; mask &= mask - 1)
        out[count++] = numbers[__builtin_ctz(mask)];
    return count;
#endif
}

/// Returns bit l set if the two highest bits of numbers[l] are `high`, for 16 numbers.
OPENFAB_INLINE uint32_t lanes_with_high_bits(const uint32_t* numbers, uint32_t high) {
#if defined(__AVX512F__)
    const __m512i highest = _mm512_srli_epi32(_mm512_loadu_si512(numbers), 30);
    return _mm512_cmpeq_epi32_mask(highest, _mm512_set1_epi32(static_cast<int>(high)));
#else
    uint32_t lanes = 0;
    for (int l = 0; l < 16; ++l)
        lanes |= (numbers[l] >> 30 == high ? 1u : 0u) << l;
    return lanes;
#endif
}

/// Sets a bit in the bytes of the lanes of the mask, of 8 or 16 lanes; reads and writes 16 bytes.
template <int lanes>
OPENFAB_INLINE void add_bit(uint32_t mask, int bit, uint8_t* bytes) {
    const __m128i lane = _mm_set_epi8(-128, 64, 32, 16, 8, 4, 2, 1, -128, 64, 32, 16, 8, 4, 2, 1);
    const __m128i half = _mm_set_epi8(1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0);
    if (lanes < 16) mask &= 0xff;
    const __m128i of_lane = _mm_shuffle_epi8(_mm_cvtsi32_si128(static_cast<int>(mask)), half);
    const __m128i in = _mm_cmpeq_epi8(_mm_and_si128(of_lane, lane), lane);
    __m128i* const to = reinterpret_cast<__m128i*>(bytes);
    const __m128i set = _mm_and_si128(in, _mm_set1_epi8(static_cast<char>(1 << bit)));
    _mm_storeu_si128(to, _mm_or_si128(_mm_loadu_si128(to), set));
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd
