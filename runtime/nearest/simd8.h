// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Eight floats side by side, for the query kernel. The kernel's source is compiled once for each
// instruction set with OPENFAB_NEAREST_ISA naming its namespace, so that no inline function of one
// set can be linked into the other. Only operations that IEEE 754 rounds in one way are here: no
// FMA, no reciprocal estimates.

#include <immintrin.h>

#include <cstdint>

#ifndef OPENFAB_NEAREST_ISA
#error "include simd8.h from a kernel translation unit only"
#endif

namespace openfab::nearest::OPENFAB_NEAREST_ISA {

#define OPENFAB_INLINE inline __attribute__((always_inline))

#if defined(__AVX2__)

struct F8 {
    __m256 v;
};
OPENFAB_INLINE F8 set1(float x) {
    return {_mm256_set1_ps(x)};
}
OPENFAB_INLINE F8 set1_bits(int32_t x) {
    return {_mm256_castsi256_ps(_mm256_set1_epi32(x))};
}
OPENFAB_INLINE F8 load(const float* p) {
    return {_mm256_load_ps(p)};
}
OPENFAB_INLINE void store(float* p, F8 a) {
    _mm256_store_ps(p, a.v);
}
OPENFAB_INLINE void store_bits(int32_t* p, F8 a) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(p), _mm256_castps_si256(a.v));
}
OPENFAB_INLINE F8 operator+(F8 a, F8 b) {
    return {_mm256_add_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 operator-(F8 a, F8 b) {
    return {_mm256_sub_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 operator*(F8 a, F8 b) {
    return {_mm256_mul_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 operator/(F8 a, F8 b) {
    return {_mm256_div_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 min(F8 a, F8 b) {
    return {_mm256_min_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 max(F8 a, F8 b) {
    return {_mm256_max_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 sqrt(F8 a) {
    return {_mm256_sqrt_ps(a.v)};
}
OPENFAB_INLINE F8 operator&(F8 a, F8 b) {
    return {_mm256_and_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 operator|(F8 a, F8 b) {
    return {_mm256_or_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 andnot(F8 a, F8 b) {
    return {_mm256_andnot_ps(a.v, b.v)};
}
OPENFAB_INLINE F8 operator<(F8 a, F8 b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)};
}
OPENFAB_INLINE F8 operator<=(F8 a, F8 b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)};
}
OPENFAB_INLINE F8 operator==(F8 a, F8 b) {
    return {_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)};
}
/// As 32-bit integers.
OPENFAB_INLINE F8 less_bits(F8 a, F8 b) {
    return {_mm256_castsi256_ps(
        _mm256_cmpgt_epi32(_mm256_castps_si256(b.v), _mm256_castps_si256(a.v)))};
}
OPENFAB_INLINE F8 equal_bits(F8 a, F8 b) {
    return {_mm256_castsi256_ps(
        _mm256_cmpeq_epi32(_mm256_castps_si256(b.v), _mm256_castps_si256(a.v)))};
}
/// mask ? a : b, lane by lane; the mask is all ones or all zeros.
OPENFAB_INLINE F8 select(F8 mask, F8 a, F8 b) {
    return {_mm256_blendv_ps(b.v, a.v, mask.v)};
}
/// Bit i: the sign of lane i.
OPENFAB_INLINE uint32_t bits(F8 mask) {
    return static_cast<uint32_t>(_mm256_movemask_ps(mask.v));
}

#else

struct F8 {
    __m128 lo, hi;
};
OPENFAB_INLINE F8 set1(float x) {
    return {_mm_set1_ps(x), _mm_set1_ps(x)};
}
OPENFAB_INLINE F8 set1_bits(int32_t x) {
    const __m128 v = _mm_castsi128_ps(_mm_set1_epi32(x));
    return {v, v};
}
OPENFAB_INLINE F8 load(const float* p) {
    return {_mm_load_ps(p), _mm_load_ps(p + 4)};
}
OPENFAB_INLINE void store(float* p, F8 a) {
    _mm_store_ps(p, a.lo);
    _mm_store_ps(p + 4, a.hi);
}
OPENFAB_INLINE void store_bits(int32_t* p, F8 a) {
    _mm_store_si128(reinterpret_cast<__m128i*>(p), _mm_castps_si128(a.lo));
    _mm_store_si128(reinterpret_cast<__m128i*>(p + 4), _mm_castps_si128(a.hi));
}
#define OPENFAB_BINARY(name, intrinsic)                        \
    OPENFAB_INLINE F8 name(F8 a, F8 b) {                       \
        return {intrinsic(a.lo, b.lo), intrinsic(a.hi, b.hi)}; \
    }
OPENFAB_BINARY(operator+, _mm_add_ps)
OPENFAB_BINARY(operator-, _mm_sub_ps)
OPENFAB_BINARY(operator*, _mm_mul_ps)
OPENFAB_BINARY(operator/, _mm_div_ps)
OPENFAB_BINARY(min, _mm_min_ps)
OPENFAB_BINARY(max, _mm_max_ps)
OPENFAB_BINARY(operator&, _mm_and_ps)
OPENFAB_BINARY(operator|, _mm_or_ps)
OPENFAB_BINARY(andnot, _mm_andnot_ps)
OPENFAB_BINARY(operator<, _mm_cmplt_ps)
OPENFAB_BINARY(operator<=, _mm_cmple_ps)
OPENFAB_BINARY(operator==, _mm_cmpeq_ps)
#undef OPENFAB_BINARY
OPENFAB_INLINE F8 sqrt(F8 a) {
    return {_mm_sqrt_ps(a.lo), _mm_sqrt_ps(a.hi)};
}
OPENFAB_INLINE __m128 less_bits4(__m128 a, __m128 b) {
    return _mm_castsi128_ps(_mm_cmpgt_epi32(_mm_castps_si128(b), _mm_castps_si128(a)));
}
OPENFAB_INLINE __m128 equal_bits4(__m128 a, __m128 b) {
    return _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_castps_si128(b), _mm_castps_si128(a)));
}
OPENFAB_INLINE F8 less_bits(F8 a, F8 b) {
    return {less_bits4(a.lo, b.lo), less_bits4(a.hi, b.hi)};
}
OPENFAB_INLINE F8 equal_bits(F8 a, F8 b) {
    return {equal_bits4(a.lo, b.lo), equal_bits4(a.hi, b.hi)};
}
OPENFAB_INLINE F8 select(F8 mask, F8 a, F8 b) {
    return {_mm_blendv_ps(b.lo, a.lo, mask.lo), _mm_blendv_ps(b.hi, a.hi, mask.hi)};
}
OPENFAB_INLINE uint32_t bits(F8 mask) {
    return static_cast<uint32_t>(_mm_movemask_ps(mask.lo)) |
           static_cast<uint32_t>(_mm_movemask_ps(mask.hi)) << 4;
}

#endif

OPENFAB_INLINE F8 absolute(F8 a) {
    return andnot(set1(-0.0f), a);
}
OPENFAB_INLINE F8 dot3(F8 ax, F8 ay, F8 az, F8 bx, F8 by, F8 bz) {
    return (ax * bx + ay * by) + az * bz;
}

}  // namespace openfab::nearest::OPENFAB_NEAREST_ISA
