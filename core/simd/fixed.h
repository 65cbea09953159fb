// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vectors of sixteen 16-bit fixed-point numbers, for pruning tests that allow for their rounding.

#include <cstdint>

#include "simd/intrinsics.h"
#include "simd/target.h"

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

#if defined(__AVX2__)

struct Fixed16 {
    static constexpr int kLanes = 16;
    __m256i v;

    Fixed16() = default;
    OPENFAB_INLINE Fixed16(__m256i all) : v(all) {}
    OPENFAB_INLINE explicit Fixed16(int32_t x) : v(_mm256_set1_epi16(static_cast<int16_t>(x))) {}

    static OPENFAB_INLINE Fixed16 load_unaligned(const int16_t* p) {
        return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
    }
};
OPENFAB_INLINE Fixed16 operator+(Fixed16 a, Fixed16 b) {
    return _mm256_add_epi16(a.v, b.v);
}
OPENFAB_INLINE Fixed16 operator-(Fixed16 a, Fixed16 b) {
    return _mm256_sub_epi16(a.v, b.v);
}
OPENFAB_INLINE Fixed16 operator|(Fixed16 a, Fixed16 b) {
    return _mm256_or_si256(a.v, b.v);
}
/// Adds with saturation.
OPENFAB_INLINE Fixed16 add_capped(Fixed16 a, Fixed16 b) {
    return _mm256_adds_epi16(a.v, b.v);
}
/// Returns a b / 2^15, rounded.
OPENFAB_INLINE Fixed16 times(Fixed16 a, Fixed16 b) {
    return _mm256_mulhrs_epi16(a.v, b.v);
}
/// Sets each lane to all ones or all zeros.
OPENFAB_INLINE Fixed16 operator>(Fixed16 a, Fixed16 b) {
    return _mm256_cmpgt_epi16(a.v, b.v);
}
OPENFAB_INLINE Fixed16 absolute(Fixed16 a) {
    return _mm256_abs_epi16(a.v);
}
OPENFAB_INLINE Fixed16 select(Fixed16 mask, Fixed16 a, Fixed16 b) {
    return _mm256_blendv_epi8(b.v, a.v, mask.v);
}
OPENFAB_INLINE uint32_t bits(Fixed16 mask) {
    return static_cast<uint32_t>(_mm_movemask_epi8(
        _mm_packs_epi16(_mm256_castsi256_si128(mask.v), _mm256_extracti128_si256(mask.v, 1))));
}

#else

struct Fixed16 {
    static constexpr int kLanes = 16;
    __m128i lo, hi;

    Fixed16() = default;
    OPENFAB_INLINE Fixed16(__m128i low, __m128i high) : lo(low), hi(high) {}
    OPENFAB_INLINE explicit Fixed16(int32_t x)
        : lo(_mm_set1_epi16(static_cast<int16_t>(x))), hi(lo) {}

    static OPENFAB_INLINE Fixed16 load_unaligned(const int16_t* p) {
        return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)),
                _mm_loadu_si128(reinterpret_cast<const __m128i*>(p + 8))};
    }
};
OPENFAB_INLINE Fixed16 operator+(Fixed16 a, Fixed16 b) {
    return {_mm_add_epi16(a.lo, b.lo), _mm_add_epi16(a.hi, b.hi)};
}
OPENFAB_INLINE Fixed16 operator-(Fixed16 a, Fixed16 b) {
    return {_mm_sub_epi16(a.lo, b.lo), _mm_sub_epi16(a.hi, b.hi)};
}
OPENFAB_INLINE Fixed16 operator|(Fixed16 a, Fixed16 b) {
    return {_mm_or_si128(a.lo, b.lo), _mm_or_si128(a.hi, b.hi)};
}
/// Adds with saturation.
OPENFAB_INLINE Fixed16 add_capped(Fixed16 a, Fixed16 b) {
    return {_mm_adds_epi16(a.lo, b.lo), _mm_adds_epi16(a.hi, b.hi)};
}
/// Returns a b / 2^15, rounded.
OPENFAB_INLINE Fixed16 times(Fixed16 a, Fixed16 b) {
    return {_mm_mulhrs_epi16(a.lo, b.lo), _mm_mulhrs_epi16(a.hi, b.hi)};
}
/// Sets each lane to all ones or all zeros.
OPENFAB_INLINE Fixed16 operator>(Fixed16 a, Fixed16 b) {
    return {_mm_cmpgt_epi16(a.lo, b.lo), _mm_cmpgt_epi16(a.hi, b.hi)};
}
OPENFAB_INLINE Fixed16 absolute(Fixed16 a) {
    return {_mm_abs_epi16(a.lo), _mm_abs_epi16(a.hi)};
}
OPENFAB_INLINE Fixed16 select(Fixed16 mask, Fixed16 a, Fixed16 b) {
    return {_mm_blendv_epi8(b.lo, a.lo, mask.lo), _mm_blendv_epi8(b.hi, a.hi, mask.hi)};
}
OPENFAB_INLINE uint32_t bits(Fixed16 mask) {
    return static_cast<uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(mask.lo, mask.hi)));
}

#endif

/// Returns the number of each lane.
OPENFAB_INLINE Fixed16 fixed_lane_numbers() {
    alignas(32) static constexpr int16_t kNumbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                         8, 9, 10, 11, 12, 13, 14, 15};
    return Fixed16::load_unaligned(kNumbers);
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd
