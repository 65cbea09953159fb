// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vectors of eight or sixteen floats for the query kernel. The kernel's source is compiled once
// for each instruction set with OPENFAB_NEAREST_ISA naming its namespace, so that no inline
// function of one set can be linked into the other. Only operations that IEEE 754 rounds in one way
// are here, no reciprocal estimates; and FMA, where it exists, under names that say that it prunes.

#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#ifndef OPENFAB_NEAREST_ISA
#error "include simd.h from a kernel translation unit only"
#endif

namespace openfab::nearest::OPENFAB_NEAREST_ISA {

#define OPENFAB_INLINE inline __attribute__((always_inline))

#define OPENFAB_BINARY(type, name, intrinsic)  \
    OPENFAB_INLINE type name(type a, type b) { \
        return {intrinsic(a.v, b.v)};          \
    }
#define OPENFAB_COMPARE(type, mask, intrinsic)       \
    OPENFAB_INLINE mask operator<(type a, type b) {  \
        return {intrinsic(a.v, b.v, _CMP_LT_OQ)};    \
    }                                                \
    OPENFAB_INLINE mask operator<=(type a, type b) { \
        return {intrinsic(a.v, b.v, _CMP_LE_OQ)};    \
    }                                                \
    OPENFAB_INLINE mask operator==(type a, type b) { \
        return {intrinsic(a.v, b.v, _CMP_EQ_OQ)};    \
    }

#if defined(__AVX2__)

struct F8 {
    static constexpr int kLanes = 8;
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
OPENFAB_BINARY(F8, operator+, _mm256_add_ps)
OPENFAB_BINARY(F8, operator-, _mm256_sub_ps)
OPENFAB_BINARY(F8, operator*, _mm256_mul_ps)
OPENFAB_BINARY(F8, operator/, _mm256_div_ps)
OPENFAB_BINARY(F8, min, _mm256_min_ps)
OPENFAB_BINARY(F8, max, _mm256_max_ps)
OPENFAB_BINARY(F8, operator&, _mm256_and_ps)
OPENFAB_BINARY(F8, operator|, _mm256_or_ps)
OPENFAB_BINARY(F8, andnot, _mm256_andnot_ps)
OPENFAB_INLINE F8 sqrt(F8 a) {
    return {_mm256_sqrt_ps(a.v)};
}
#if defined(__AVX512VL__)

/// Result of comparisons: bit i for lane i.
struct M8 {
    __mmask8 v;
};
OPENFAB_COMPARE(F8, M8, _mm256_cmp_ps_mask)
OPENFAB_BINARY(M8, operator&, _kand_mask8)
OPENFAB_BINARY(M8, operator|, _kor_mask8)
OPENFAB_BINARY(M8, andnot, _kandn_mask8)
OPENFAB_INLINE F8 select(M8 mask, F8 a, F8 b) {
    return {_mm256_mask_blend_ps(mask.v, b.v, a.v)};
}
OPENFAB_INLINE uint32_t bits(M8 mask) {
    return _cvtmask8_u32(mask.v);
}
OPENFAB_INLINE bool any(M8 mask) {
    return _kortestz_mask8_u8(mask.v, mask.v) == 0;
}
OPENFAB_INLINE M8 mask_of(uint32_t bits8) {
    return {_cvtu32_mask8(bits8)};
}

#else

/// Result of comparisons: all ones or all zeros in each lane.
using M8 = F8;
OPENFAB_COMPARE(F8, M8, _mm256_cmp_ps)
/// Returns mask ? a : b, lane by lane; the mask is all ones or all zeros.
OPENFAB_INLINE F8 select(F8 mask, F8 a, F8 b) {
    return {_mm256_blendv_ps(b.v, a.v, mask.v)};
}
/// Bit i: the sign of lane i.
OPENFAB_INLINE uint32_t bits(M8 mask) {
    return static_cast<uint32_t>(_mm256_movemask_ps(mask.v));
}

#endif

#else

struct F8 {
    static constexpr int kLanes = 8;
    __m128 lo, hi;
};
using M8 = F8;
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
#define OPENFAB_HALVES(name, intrinsic)                        \
    OPENFAB_INLINE F8 name(F8 a, F8 b) {                       \
        return {intrinsic(a.lo, b.lo), intrinsic(a.hi, b.hi)}; \
    }
OPENFAB_HALVES(operator+, _mm_add_ps)
OPENFAB_HALVES(operator-, _mm_sub_ps)
OPENFAB_HALVES(operator*, _mm_mul_ps)
OPENFAB_HALVES(operator/, _mm_div_ps)
OPENFAB_HALVES(min, _mm_min_ps)
OPENFAB_HALVES(max, _mm_max_ps)
OPENFAB_HALVES(operator&, _mm_and_ps)
OPENFAB_HALVES(operator|, _mm_or_ps)
OPENFAB_HALVES(andnot, _mm_andnot_ps)
OPENFAB_HALVES(operator<, _mm_cmplt_ps)
OPENFAB_HALVES(operator<=, _mm_cmple_ps)
OPENFAB_HALVES(operator==, _mm_cmpeq_ps)
#undef OPENFAB_HALVES
OPENFAB_INLINE F8 sqrt(F8 a) {
    return {_mm_sqrt_ps(a.lo), _mm_sqrt_ps(a.hi)};
}
OPENFAB_INLINE F8 select(F8 mask, F8 a, F8 b) {
    return {_mm_blendv_ps(b.lo, a.lo, mask.lo), _mm_blendv_ps(b.hi, a.hi, mask.hi)};
}
OPENFAB_INLINE uint32_t bits(F8 mask) {
    return static_cast<uint32_t>(_mm_movemask_ps(mask.lo)) |
           static_cast<uint32_t>(_mm_movemask_ps(mask.hi)) << 4;
}

#endif

#if !defined(__AVX512VL__)
OPENFAB_INLINE bool any(M8 mask) {
    return bits(mask) != 0;
}
OPENFAB_INLINE M8 mask_of(uint32_t bits8) {
    alignas(32) float lanes[8];
    for (int l = 0; l < 8; ++l)
        lanes[l] = (bits8 >> l & 1u) != 0 ? -1.0f : 1.0f;
    return load(lanes) < set1(0.0f);
}
#endif

#if defined(__AVX512F__)

struct M16 {
    __mmask16 v;
};
struct F16 {
    static constexpr int kLanes = 16;
    __m512 v;
};
OPENFAB_BINARY(F16, operator+, _mm512_add_ps)
OPENFAB_BINARY(F16, operator-, _mm512_sub_ps)
OPENFAB_BINARY(F16, operator*, _mm512_mul_ps)
OPENFAB_BINARY(F16, operator/, _mm512_div_ps)
OPENFAB_BINARY(F16, min, _mm512_min_ps)
OPENFAB_BINARY(F16, max, _mm512_max_ps)
OPENFAB_BINARY(F16, andnot, _mm512_andnot_ps)
OPENFAB_INLINE F16 sqrt(F16 a) {
    return {_mm512_sqrt_ps(a.v)};
}
OPENFAB_COMPARE(F16, M16, _mm512_cmp_ps_mask)
OPENFAB_BINARY(M16, operator&, _kand_mask16)
OPENFAB_BINARY(M16, operator|, _kor_mask16)
OPENFAB_BINARY(M16, andnot, _kandn_mask16)
OPENFAB_INLINE F16 select(M16 mask, F16 a, F16 b) {
    return {_mm512_mask_blend_ps(mask.v, b.v, a.v)};
}
OPENFAB_INLINE bool any(M16 mask) {
    return _kortestz_mask16_u8(mask.v, mask.v) == 0;
}
OPENFAB_INLINE uint32_t bits(M16 mask) {
    return _cvtmask16_u32(mask.v);
}
OPENFAB_INLINE void store(float* p, F16 a) {
    _mm512_store_ps(p, a.v);
}
OPENFAB_INLINE void store_bits(int32_t* p, F16 a) {
    _mm512_store_si512(p, _mm512_castps_si512(a.v));
}

#endif

/// Operations of a vector type; loops over features are written for any width.
template <typename V>
struct Width;
template <>
struct Width<F8> {
    static OPENFAB_INLINE F8 splat(float x) { return set1(x); }
    static OPENFAB_INLINE F8 splat_bits(int32_t x) { return set1_bits(x); }
    static OPENFAB_INLINE F8 load(const float* p) { return OPENFAB_NEAREST_ISA::load(p); }
    static OPENFAB_INLINE F8 join(const F8* parts) { return parts[0]; }
    static OPENFAB_INLINE M8 mask(uint32_t bits) { return mask_of(bits); }
};
#if defined(__AVX512F__)
template <>
struct Width<F16> {
    static OPENFAB_INLINE F16 splat(float x) { return {_mm512_set1_ps(x)}; }
    static OPENFAB_INLINE F16 splat_bits(int32_t x) {
        return {_mm512_castsi512_ps(_mm512_set1_epi32(x))};
    }
    static OPENFAB_INLINE F16 load(const float* p) { return {_mm512_load_ps(p)}; }
    static OPENFAB_INLINE F16 join(const F8* parts) {
        return {_mm512_insertf32x8(_mm512_castps256_ps512(parts[0].v), parts[1].v, 1)};
    }
    static OPENFAB_INLINE M16 mask(uint32_t bits) { return {_cvtu32_mask16(bits)}; }
};
using Widest = F16;
#else
using Widest = F8;
#endif
template <typename V>
OPENFAB_INLINE V splat(float x) {
    return Width<V>::splat(x);
}
/// The mask type of V.
template <typename V>
using MaskOf = decltype(V{} < V{});
/// Writes first + l for each lane l of the mask, in order; returns their number. May write up to
/// V::kLanes values.
template <typename V>
OPENFAB_INLINE uint32_t list_lanes(uint32_t mask, uint32_t first, uint32_t* out) {
#if defined(__AVX512F__)
    if constexpr (V::kLanes == 16) {
        const __m512i lanes = _mm512_add_epi32(
            _mm512_set1_epi32(static_cast<int>(first)),
            _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0));
        _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(static_cast<__mmask16>(mask), lanes));
        return static_cast<uint32_t>(__builtin_popcount(mask));
    }
#endif
    uint32_t count = 0;
    for (int l = 0; l < V::kLanes; ++l) {
        out[count] = first + static_cast<uint32_t>(l);
        count += mask >> l & 1u;
    }
    return count;
}

/// Sets a bit in the bytes of the lanes of the mask; reads and writes 16 bytes.
template <typename V>
OPENFAB_INLINE void add_bit(uint32_t mask, int bit, uint8_t* bytes) {
    const __m128i lane = _mm_set_epi8(-128, 64, 32, 16, 8, 4, 2, 1, -128, 64, 32, 16, 8, 4, 2, 1);
    const __m128i half = _mm_set_epi8(1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0);
    if (V::kLanes < 16) mask &= 0xff;
    const __m128i of_lane = _mm_shuffle_epi8(_mm_cvtsi32_si128(static_cast<int>(mask)), half);
    const __m128i in = _mm_cmpeq_epi8(_mm_and_si128(of_lane, lane), lane);
    __m128i* const to = reinterpret_cast<__m128i*>(bytes);
    const __m128i set = _mm_and_si128(in, _mm_set1_epi8(static_cast<char>(1 << bit)));
    _mm_storeu_si128(to, _mm_or_si128(_mm_loadu_si128(to), set));
}

#if defined(__AVX2__)
/// Transposes an 8 x 8 matrix of floats.
OPENFAB_INLINE void transpose8(const float* const* rows, size_t first, F8* columns) {
    __m256 r[8], s[8];
    for (int i = 0; i < 8; ++i)
        r[i] = _mm256_load_ps(rows[i] + first);
    for (int i = 0; i < 8; i += 2) {
        s[i] = _mm256_unpacklo_ps(r[i], r[i + 1]);
        s[i + 1] = _mm256_unpackhi_ps(r[i], r[i + 1]);
    }
    for (int i = 0; i < 8; i += 4) {
        r[i] = _mm256_shuffle_ps(s[i], s[i + 2], 0x44);
        r[i + 1] = _mm256_shuffle_ps(s[i], s[i + 2], 0xee);
        r[i + 2] = _mm256_shuffle_ps(s[i + 1], s[i + 3], 0x44);
        r[i + 3] = _mm256_shuffle_ps(s[i + 1], s[i + 3], 0xee);
    }
    for (int i = 0; i < 4; ++i) {
        columns[i].v = _mm256_permute2f128_ps(r[i], r[i + 4], 0x20);
        columns[i + 4].v = _mm256_permute2f128_ps(r[i], r[i + 4], 0x31);
    }
}
#else
OPENFAB_INLINE void transpose8(const float* const* rows, size_t first, F8* columns) {
    for (int i = 0; i < 8; i += 4) {
        __m128 lo[4], hi[4];
        for (int k = 0; k < 4; ++k) {
            lo[k] = _mm_load_ps(rows[k] + first + i);
            hi[k] = _mm_load_ps(rows[k + 4] + first + i);
        }
        _MM_TRANSPOSE4_PS(lo[0], lo[1], lo[2], lo[3]);
        _MM_TRANSPOSE4_PS(hi[0], hi[1], hi[2], hi[3]);
        for (int k = 0; k < 4; ++k)
            columns[i + k] = {lo[k], hi[k]};
    }
}
#endif

/// Transposes 16 columns: lane l of column k is rows[l][first + k]; rows are aligned like vectors.
OPENFAB_INLINE void transpose(const float* const* rows, size_t first, F8* columns) {
    transpose8(rows, first, columns);
    transpose8(rows, first + 8, columns + 8);
}
#if defined(__AVX512F__)
OPENFAB_INLINE void transpose(const float* const* rows, size_t first, F16* columns) {
    __m512 r[16], s[16];
    for (int i = 0; i < 16; ++i)
        r[i] = _mm512_load_ps(rows[i] + first);
    for (int i = 0; i < 16; i += 2) {
        s[i] = _mm512_unpacklo_ps(r[i], r[i + 1]);
        s[i + 1] = _mm512_unpackhi_ps(r[i], r[i + 1]);
    }
    // Lane 4j + k of r[4i + c] is column 4j + c of row 4i + k.
    for (int i = 0; i < 16; i += 4) {
        r[i] = _mm512_shuffle_ps(s[i], s[i + 2], 0x44);
        r[i + 1] = _mm512_shuffle_ps(s[i], s[i + 2], 0xee);
        r[i + 2] = _mm512_shuffle_ps(s[i + 1], s[i + 3], 0x44);
        r[i + 3] = _mm512_shuffle_ps(s[i + 1], s[i + 3], 0xee);
    }
    for (int c = 0; c < 4; ++c) {
        const __m512 even01 = _mm512_shuffle_f32x4(r[c], r[c + 4], 0x88);
        const __m512 odd01 = _mm512_shuffle_f32x4(r[c], r[c + 4], 0xdd);
        const __m512 even23 = _mm512_shuffle_f32x4(r[c + 8], r[c + 12], 0x88);
        const __m512 odd23 = _mm512_shuffle_f32x4(r[c + 8], r[c + 12], 0xdd);
        columns[c].v = _mm512_shuffle_f32x4(even01, even23, 0x88);
        columns[c + 4].v = _mm512_shuffle_f32x4(odd01, odd23, 0x88);
        columns[c + 8].v = _mm512_shuffle_f32x4(even01, even23, 0xdd);
        columns[c + 12].v = _mm512_shuffle_f32x4(odd01, odd23, 0xdd);
    }
}
#endif

template <typename V>
OPENFAB_INLINE V absolute(V a) {
    return andnot(splat<V>(-0.0f), a);
}

// a b + c and a b - c, rounded once or twice: for pruning tests, which allow for either, never for
// an answer.
#define OPENFAB_TERNARY(type, name, intrinsic)         \
    OPENFAB_INLINE type name(type a, type b, type c) { \
        return {intrinsic(a.v, b.v, c.v)};             \
    }
#if defined(__FMA__)
OPENFAB_TERNARY(F8, about_mul_add, _mm256_fmadd_ps)
OPENFAB_TERNARY(F8, about_mul_sub, _mm256_fmsub_ps)
#else
OPENFAB_INLINE F8 about_mul_add(F8 a, F8 b, F8 c) {
    return a * b + c;
}
OPENFAB_INLINE F8 about_mul_sub(F8 a, F8 b, F8 c) {
    return a * b - c;
}
#endif
#if defined(__AVX512F__)
OPENFAB_TERNARY(F16, about_mul_add, _mm512_fmadd_ps)
OPENFAB_TERNARY(F16, about_mul_sub, _mm512_fmsub_ps)
#endif

OPENFAB_INLINE F8 dot3(F8 ax, F8 ay, F8 az, F8 bx, F8 by, F8 bz) {
    return (ax * bx + ay * by) + az * bz;
}

}  // namespace openfab::nearest::OPENFAB_NEAREST_ISA
