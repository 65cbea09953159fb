// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vectors of sixteen 16-bit fixed-point numbers, for pruning tests that allow for their rounding.
// For kernel translation units only, like simd.h.

#include "runtime/nearest/kernel/simd.h"

namespace openfab::nearest::OPENFAB_NEAREST_ISA {

#if defined(__AVX2__)

struct I16 {
    static constexpr int kLanes = 16;
    __m256i v;
};
OPENFAB_INLINE I16 load_fixed(const int16_t* p) {
    return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p))};
}
OPENFAB_INLINE I16 splat_fixed(int32_t x) {
    return {_mm256_set1_epi16(static_cast<int16_t>(x))};
}
OPENFAB_BINARY(I16, operator+, _mm256_add_epi16)
OPENFAB_BINARY(I16, operator-, _mm256_sub_epi16)
OPENFAB_BINARY(I16, operator|, _mm256_or_si256)
/// Adds with saturation.
OPENFAB_BINARY(I16, add_capped, _mm256_adds_epi16)
/// Returns a b / 2^15, rounded.
OPENFAB_BINARY(I16, times, _mm256_mulhrs_epi16)
/// Sets each lane to all ones or all zeros.
OPENFAB_BINARY(I16, operator>, _mm256_cmpgt_epi16)
OPENFAB_INLINE I16 absolute(I16 a) {
    return {_mm256_abs_epi16(a.v)};
}
OPENFAB_INLINE I16 select(I16 mask, I16 a, I16 b) {
    return {_mm256_blendv_epi8(b.v, a.v, mask.v)};
}
OPENFAB_INLINE uint32_t bits(I16 mask) {
    return static_cast<uint32_t>(_mm_movemask_epi8(
        _mm_packs_epi16(_mm256_castsi256_si128(mask.v), _mm256_extracti128_si256(mask.v, 1))));
}

#else

struct I16 {
    static constexpr int kLanes = 16;
    __m128i lo, hi;
};
OPENFAB_INLINE I16 load_fixed(const int16_t* p) {
    return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)),
            _mm_loadu_si128(reinterpret_cast<const __m128i*>(p + 8))};
}
OPENFAB_INLINE I16 splat_fixed(int32_t x) {
    const __m128i v = _mm_set1_epi16(static_cast<int16_t>(x));
    return {v, v};
}
#define OPENFAB_HALVES(name, intrinsic)                        \
    OPENFAB_INLINE I16 name(I16 a, I16 b) {                    \
        return {intrinsic(a.lo, b.lo), intrinsic(a.hi, b.hi)}; \
    }
OPENFAB_HALVES(operator+, _mm_add_epi16)
OPENFAB_HALVES(operator-, _mm_sub_epi16)
OPENFAB_HALVES(operator|, _mm_or_si128)
OPENFAB_HALVES(add_capped, _mm_adds_epi16)
OPENFAB_HALVES(times, _mm_mulhrs_epi16)
OPENFAB_HALVES(operator>, _mm_cmpgt_epi16)
#undef OPENFAB_HALVES
OPENFAB_INLINE I16 absolute(I16 a) {
    return {_mm_abs_epi16(a.lo), _mm_abs_epi16(a.hi)};
}
OPENFAB_INLINE I16 select(I16 mask, I16 a, I16 b) {
    return {_mm_blendv_epi8(b.lo, a.lo, mask.lo), _mm_blendv_epi8(b.hi, a.hi, mask.hi)};
}
OPENFAB_INLINE uint32_t bits(I16 mask) {
    return static_cast<uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(mask.lo, mask.hi)));
}

#endif

/// Returns the number of each lane.
OPENFAB_INLINE I16 lane_numbers() {
    alignas(32) static constexpr int16_t kNumbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                         8, 9, 10, 11, 12, 13, 14, 15};
    return load_fixed(kNumbers);
}

/// Rounds eight numbers to integers and stores them.
OPENFAB_INLINE void store_rounded(int32_t* out, F8 a) {
#if defined(__AVX2__)
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm256_cvtps_epi32(a.v));
#else
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_cvtps_epi32(a.lo));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 4), _mm_cvtps_epi32(a.hi));
#endif
}

/// Writes numbers[l] for each lane l of the mask, in order; returns their number. May write up to
/// 16 values.
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

/// Returns bit l set if the two highest bits of numbers[l] are `kind`.
OPENFAB_INLINE uint32_t lanes_of_kind(const uint32_t* numbers, uint32_t kind) {
#if defined(__AVX512F__)
    const __m512i kinds = _mm512_srli_epi32(_mm512_loadu_si512(numbers), 30);
    return _mm512_cmpeq_epi32_mask(kinds, _mm512_set1_epi32(static_cast<int>(kind)));
#else
    uint32_t lanes = 0;
    for (int l = 0; l < 16; ++l)
        lanes |= (numbers[l] >> 30 == kind ? 1u : 0u) << l;
    return lanes;
#endif
}

}  // namespace openfab::nearest::OPENFAB_NEAREST_ISA
