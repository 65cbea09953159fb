// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The registers of AVX-512: sixteen lanes. Part of vectors.h.

#include <cstdint>

#include "simd/intrinsics.h"
#include "simd/target.h"
#include "simd/vectors_avx2.h"

#if defined(__AVX512F__)

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

struct Mask16 {
    __mmask16 v;

    static OPENFAB_INLINE Mask16 from_bits(uint32_t bits) { return {_cvtu32_mask16(bits)}; }
};
OPENFAB_INLINE Mask16 operator&(Mask16 a, Mask16 b) {
    return {_kand_mask16(a.v, b.v)};
}
OPENFAB_INLINE Mask16 operator|(Mask16 a, Mask16 b) {
    return {_kor_mask16(a.v, b.v)};
}
OPENFAB_INLINE Mask16 andnot(Mask16 a, Mask16 b) {
    return {_kandn_mask16(a.v, b.v)};
}
OPENFAB_INLINE uint32_t bits(Mask16 a) {
    return _cvtmask16_u32(a.v);
}
OPENFAB_INLINE bool any(Mask16 a) {
    return _kortestz_mask16_u8(a.v, a.v) == 0;
}

struct Ints16 {
    static constexpr int kLanes = 16;
    __m512i v;

    Ints16() = default;
    OPENFAB_INLINE Ints16(__m512i all) : v(all) {}
    OPENFAB_INLINE Ints16(int32_t x) : v(_mm512_set1_epi32(x)) {}

    static OPENFAB_INLINE Ints16 load(const int32_t* p) { return _mm512_load_si512(p); }
};
OPENFAB_INLINE void store(int32_t* p, Ints16 a) {
    _mm512_store_si512(p, a.v);
}
OPENFAB_INLINE Ints16 select(Mask16 mask, Ints16 a, Ints16 b) {
    return _mm512_mask_blend_epi32(mask.v, b.v, a.v);
}

struct Floats16 {
    static constexpr int kLanes = 16;
    using Mask = Mask16;
    using Ints = Ints16;
    __m512 v;

    Floats16() = default;
    OPENFAB_INLINE Floats16(__m512 all) : v(all) {}
    OPENFAB_INLINE Floats16(float x) : v(_mm512_set1_ps(x)) {}

    static OPENFAB_INLINE Floats16 load(const float* p) { return _mm512_load_ps(p); }
    static OPENFAB_INLINE Floats16 join(const Floats8* parts) {
        return _mm512_insertf32x8(_mm512_castps256_ps512(parts[0].v), parts[1].v, 1);
    }
};
OPENFAB_INLINE Floats16 operator+(Floats16 a, Floats16 b) {
    return _mm512_add_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 operator-(Floats16 a, Floats16 b) {
    return _mm512_sub_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 operator*(Floats16 a, Floats16 b) {
    return _mm512_mul_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 operator/(Floats16 a, Floats16 b) {
    return _mm512_div_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 min(Floats16 a, Floats16 b) {
    return _mm512_min_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 max(Floats16 a, Floats16 b) {
    return _mm512_max_ps(a.v, b.v);
}
OPENFAB_INLINE Floats16 sqrt(Floats16 a) {
    return _mm512_sqrt_ps(a.v);
}
OPENFAB_INLINE Floats16 absolute(Floats16 a) {
    return _mm512_andnot_ps(_mm512_set1_ps(-0.0f), a.v);
}
OPENFAB_INLINE Floats16 about_mul_add(Floats16 a, Floats16 b, Floats16 c) {
    return _mm512_fmadd_ps(a.v, b.v, c.v);
}
OPENFAB_INLINE Floats16 about_mul_sub(Floats16 a, Floats16 b, Floats16 c) {
    return _mm512_fmsub_ps(a.v, b.v, c.v);
}
OPENFAB_INLINE Mask16 operator<(Floats16 a, Floats16 b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)};
}
OPENFAB_INLINE Mask16 operator<=(Floats16 a, Floats16 b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)};
}
OPENFAB_INLINE Mask16 operator==(Floats16 a, Floats16 b) {
    return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)};
}
OPENFAB_INLINE Floats16 select(Mask16 mask, Floats16 a, Floats16 b) {
    return _mm512_mask_blend_ps(mask.v, b.v, a.v);
}
OPENFAB_INLINE void store(float* p, Floats16 a) {
    _mm512_store_ps(p, a.v);
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd

#endif
