// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The registers of AVX2: eight lanes. Part of vectors.h. With AVX-512, masks are in mask registers.

#include <cstdint>

#include "simd/intrinsics.h"
#include "simd/target.h"

#if defined(__AVX2__)

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

#if defined(__AVX512VL__)

struct Mask8 {
    __mmask8 v;

    static OPENFAB_INLINE Mask8 from_bits(uint32_t bits) { return {_cvtu32_mask8(bits)}; }
    static OPENFAB_INLINE Mask8 all() { return from_bits(0xff); }
};
OPENFAB_INLINE Mask8 operator&(Mask8 a, Mask8 b) {
    return {_kand_mask8(a.v, b.v)};
}
OPENFAB_INLINE Mask8 operator|(Mask8 a, Mask8 b) {
    return {_kor_mask8(a.v, b.v)};
}
OPENFAB_INLINE Mask8 andnot(Mask8 a, Mask8 b) {
    return {_kandn_mask8(a.v, b.v)};
}
OPENFAB_INLINE uint32_t bits(Mask8 a) {
    return _cvtmask8_u32(a.v);
}
OPENFAB_INLINE bool any(Mask8 a) {
    return _kortestz_mask8_u8(a.v, a.v) == 0;
}

#else

/// All ones or all zeros in each lane.
struct Mask8 {
    __m256 v;

    static OPENFAB_INLINE Mask8 from_bits(uint32_t bits) {
        const __m256i lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        const __m256i all = _mm256_set1_epi32(static_cast<int32_t>(bits));
        return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(all, lane), lane))};
    }
    static OPENFAB_INLINE Mask8 all() { return {_mm256_castsi256_ps(_mm256_set1_epi32(-1))}; }
};
OPENFAB_INLINE Mask8 operator&(Mask8 a, Mask8 b) {
    return {_mm256_and_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask8 operator|(Mask8 a, Mask8 b) {
    return {_mm256_or_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask8 andnot(Mask8 a, Mask8 b) {
    return {_mm256_andnot_ps(a.v, b.v)};
}
OPENFAB_INLINE uint32_t bits(Mask8 a) {
    return static_cast<uint32_t>(_mm256_movemask_ps(a.v));
}
OPENFAB_INLINE bool any(Mask8 a) {
    return bits(a) != 0;
}

#endif

struct Ints8 {
    static constexpr int kLanes = 8;
    using Register = int32_t __attribute__((vector_size(32)));
    /// Arithmetic uses these, whose overflow is defined.
    using Wrapping = uint32_t __attribute__((vector_size(32)));
    Register v;

    Ints8() = default;
    OPENFAB_INLINE Ints8(Register all) : v(all) {}
    OPENFAB_INLINE Ints8(__m256i all) : v(reinterpret_cast<Register>(all)) {}
    OPENFAB_INLINE Ints8(int32_t x) : Ints8(_mm256_set1_epi32(x)) {}
    OPENFAB_INLINE __m256i raw() const { return reinterpret_cast<__m256i>(v); }
    OPENFAB_INLINE int32_t lane(int l) const { return v[l]; }

    static OPENFAB_INLINE Ints8 load(const int32_t* p) {
        return _mm256_load_si256(reinterpret_cast<const __m256i*>(p));
    }
    /// Converts 8 numbers.
    static OPENFAB_INLINE Ints8 load_unaligned(const uint16_t* p) {
        return _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
    }
    static OPENFAB_INLINE Ints8 load_unaligned(const uint8_t* p) {
        return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
    }
    /// Returns f(0), f(1), …
    template <typename F>
    static OPENFAB_INLINE Ints8 generate(const F& f) {
        return Register{f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)};
    }
    /// Returns 0, 1, 2, …
    static OPENFAB_INLINE Ints8 lane_numbers() { return Register{0, 1, 2, 3, 4, 5, 6, 7}; }

    OPENFAB_INLINE Ints8& operator+=(Ints8 b) {
        v = Register(Wrapping(v) + Wrapping(b.v));
        return *this;
    }
    OPENFAB_INLINE Ints8& operator-=(Ints8 b) {
        v = Register(Wrapping(v) - Wrapping(b.v));
        return *this;
    }
};
OPENFAB_INLINE Ints8 operator+(Ints8 a, Ints8 b) {
    return Ints8::Register(Ints8::Wrapping(a.v) + Ints8::Wrapping(b.v));
}
OPENFAB_INLINE Ints8 operator-(Ints8 a, Ints8 b) {
    return Ints8::Register(Ints8::Wrapping(a.v) - Ints8::Wrapping(b.v));
}
OPENFAB_INLINE Ints8 operator*(Ints8 a, Ints8 b) {
    return Ints8::Register(Ints8::Wrapping(a.v) * Ints8::Wrapping(b.v));
}
OPENFAB_INLINE Ints8 operator&(Ints8 a, Ints8 b) {
    return a.v & b.v;
}
OPENFAB_INLINE Ints8 operator|(Ints8 a, Ints8 b) {
    return a.v | b.v;
}
OPENFAB_INLINE Ints8 operator>>(Ints8 a, int by) {
    return a.v >> by;
}
OPENFAB_INLINE Ints8 min(Ints8 a, Ints8 b) {
    return _mm256_min_epi32(a.raw(), b.raw());
}
OPENFAB_INLINE Ints8 max(Ints8 a, Ints8 b) {
    return _mm256_max_epi32(a.raw(), b.raw());
}
OPENFAB_INLINE void store(int32_t* p, Ints8 a) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(p), a.raw());
}
OPENFAB_INLINE void store_unaligned(int32_t* p, Ints8 a) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.raw());
}
/// Stores the low byte of each lane.
OPENFAB_INLINE void store_low_bytes(uint8_t* p, Ints8 a) {
    const __m256i packed = _mm256_shuffle_epi8(a.raw(), _mm256_set1_epi32(0x0c080400));
    const __m128i bytes =
        _mm_unpacklo_epi32(_mm256_castsi256_si128(packed), _mm256_extracti128_si256(packed, 1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(p), bytes);
}

struct Uints8 {
    using Register = uint32_t __attribute__((vector_size(32)));
    Register v;

    OPENFAB_INLINE explicit Uints8(Register all) : v(all) {}
    OPENFAB_INLINE explicit Uints8(uint32_t x) : v(Register{} + x) {}
    OPENFAB_INLINE explicit Uints8(Ints8 a) : v(reinterpret_cast<Register>(a.v)) {}
};
OPENFAB_INLINE Uints8 operator*(Uints8 a, Uints8 b) {
    return Uints8(a.v * b.v);
}
OPENFAB_INLINE Uints8 operator^(Uints8 a, Uints8 b) {
    return Uints8(a.v ^ b.v);
}
OPENFAB_INLINE Uints8 operator>>(Uints8 a, Uints8 b) {
    return Uints8(a.v >> b.v);
}
OPENFAB_INLINE Ints8 as_ints(Uints8 a) {
    return reinterpret_cast<Ints8::Register>(a.v);
}

struct Floats8 {
    static constexpr int kLanes = 8;
    using Mask = Mask8;
    using Ints = Ints8;
    __m256 v;

    Floats8() = default;
    OPENFAB_INLINE Floats8(__m256 all) : v(all) {}
    OPENFAB_INLINE Floats8(float x) : v(_mm256_set1_ps(x)) {}

    static OPENFAB_INLINE Floats8 load(const float* p) { return _mm256_load_ps(p); }
    static OPENFAB_INLINE Floats8 load_unaligned(const float* p) { return _mm256_loadu_ps(p); }
    /// Joins kLanes / 8 vectors of eight lanes.
    static OPENFAB_INLINE Floats8 join(const Floats8* parts) { return parts[0]; }

    OPENFAB_INLINE Floats8& operator+=(Floats8 b) {
        v = _mm256_add_ps(v, b.v);
        return *this;
    }
    OPENFAB_INLINE Floats8& operator-=(Floats8 b) {
        v = _mm256_sub_ps(v, b.v);
        return *this;
    }
};
OPENFAB_INLINE Floats8 operator+(Floats8 a, Floats8 b) {
    return _mm256_add_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 operator-(Floats8 a, Floats8 b) {
    return _mm256_sub_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 operator*(Floats8 a, Floats8 b) {
    return _mm256_mul_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 operator/(Floats8 a, Floats8 b) {
    return _mm256_div_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 min(Floats8 a, Floats8 b) {
    return _mm256_min_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 max(Floats8 a, Floats8 b) {
    return _mm256_max_ps(a.v, b.v);
}
OPENFAB_INLINE Floats8 sqrt(Floats8 a) {
    return _mm256_sqrt_ps(a.v);
}
OPENFAB_INLINE Floats8 floor(Floats8 a) {
    return _mm256_floor_ps(a.v);
}
OPENFAB_INLINE Floats8 ceil(Floats8 a) {
    return _mm256_ceil_ps(a.v);
}
OPENFAB_INLINE Floats8 absolute(Floats8 a) {
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v);
}
OPENFAB_INLINE void store(float* p, Floats8 a) {
    _mm256_store_ps(p, a.v);
}
OPENFAB_INLINE void store_unaligned(float* p, Floats8 a) {
    _mm256_storeu_ps(p, a.v);
}
OPENFAB_INLINE Ints8 as_ints(Floats8 a) {
    return _mm256_castps_si256(a.v);
}
OPENFAB_INLINE Floats8 as_floats(Ints8 a) {
    return _mm256_castsi256_ps(a.raw());
}
OPENFAB_INLINE Floats8 to_floats(Ints8 a) {
    return _mm256_cvtepi32_ps(a.raw());
}
OPENFAB_INLINE Ints8 to_ints(Floats8 a) {
    return _mm256_cvttps_epi32(a.v);
}
OPENFAB_INLINE Ints8 round_to_ints(Floats8 a) {
    return _mm256_cvtps_epi32(a.v);
}

#if defined(__FMA__)
OPENFAB_INLINE Floats8 about_mul_add(Floats8 a, Floats8 b, Floats8 c) {
    return _mm256_fmadd_ps(a.v, b.v, c.v);
}
OPENFAB_INLINE Floats8 about_mul_sub(Floats8 a, Floats8 b, Floats8 c) {
    return _mm256_fmsub_ps(a.v, b.v, c.v);
}
#else
OPENFAB_INLINE Floats8 about_mul_add(Floats8 a, Floats8 b, Floats8 c) {
    return a * b + c;
}
OPENFAB_INLINE Floats8 about_mul_sub(Floats8 a, Floats8 b, Floats8 c) {
    return a * b - c;
}
#endif

#if defined(__AVX512VL__)

template <int predicate>
OPENFAB_INLINE Mask8 compare(Floats8 a, Floats8 b) {
    return {_mm256_cmp_ps_mask(a.v, b.v, predicate)};
}
OPENFAB_INLINE Mask8 operator>(Ints8 a, Ints8 b) {
    return {_mm256_cmpgt_epi32_mask(a.raw(), b.raw())};
}
OPENFAB_INLINE Mask8 operator==(Ints8 a, Ints8 b) {
    return {_mm256_cmpeq_epi32_mask(a.raw(), b.raw())};
}
OPENFAB_INLINE Floats8 select(Mask8 mask, Floats8 a, Floats8 b) {
    return _mm256_mask_blend_ps(mask.v, b.v, a.v);
}
OPENFAB_INLINE Floats8 masked(Mask8 mask, Floats8 a) {
    return _mm256_maskz_mov_ps(mask.v, a.v);
}
OPENFAB_INLINE Floats8 andnot(Mask8 mask, Floats8 a) {
    return _mm256_maskz_mov_ps(_knot_mask8(mask.v), a.v);
}
OPENFAB_INLINE Ints8 select(Mask8 mask, Ints8 a, Ints8 b) {
    return _mm256_mask_blend_epi32(mask.v, b.raw(), a.raw());
}
OPENFAB_INLINE Ints8 masked(Mask8 mask, Ints8 a) {
    return _mm256_maskz_mov_epi32(mask.v, a.raw());
}
/// Returns -1 or 0 in each lane.
OPENFAB_INLINE Ints8 as_ints(Mask8 mask) {
    return _mm256_movm_epi32(mask.v);
}

#else

template <int predicate>
OPENFAB_INLINE Mask8 compare(Floats8 a, Floats8 b) {
    return {_mm256_cmp_ps(a.v, b.v, predicate)};
}
OPENFAB_INLINE Mask8 operator>(Ints8 a, Ints8 b) {
    return {_mm256_castsi256_ps(_mm256_cmpgt_epi32(a.raw(), b.raw()))};
}
OPENFAB_INLINE Mask8 operator==(Ints8 a, Ints8 b) {
    return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.raw(), b.raw()))};
}
OPENFAB_INLINE Floats8 select(Mask8 mask, Floats8 a, Floats8 b) {
    return _mm256_blendv_ps(b.v, a.v, mask.v);
}
OPENFAB_INLINE Floats8 masked(Mask8 mask, Floats8 a) {
    return _mm256_and_ps(mask.v, a.v);
}
OPENFAB_INLINE Floats8 andnot(Mask8 mask, Floats8 a) {
    return _mm256_andnot_ps(mask.v, a.v);
}
OPENFAB_INLINE Ints8 select(Mask8 mask, Ints8 a, Ints8 b) {
    return as_ints(select(mask, as_floats(a), as_floats(b)));
}
OPENFAB_INLINE Ints8 masked(Mask8 mask, Ints8 a) {
    return as_ints(masked(mask, as_floats(a)));
}
/// Returns -1 or 0 in each lane.
OPENFAB_INLINE Ints8 as_ints(Mask8 mask) {
    return _mm256_castps_si256(mask.v);
}

#endif

OPENFAB_INLINE Mask8 operator<(Floats8 a, Floats8 b) {
    return compare<_CMP_LT_OQ>(a, b);
}
OPENFAB_INLINE Mask8 operator<=(Floats8 a, Floats8 b) {
    return compare<_CMP_LE_OQ>(a, b);
}
OPENFAB_INLINE Mask8 operator==(Floats8 a, Floats8 b) {
    return compare<_CMP_EQ_OQ>(a, b);
}
OPENFAB_INLINE Mask8 operator>(Floats8 a, Floats8 b) {
    return b < a;
}
OPENFAB_INLINE Mask8 operator>=(Floats8 a, Floats8 b) {
    return b <= a;
}
OPENFAB_INLINE Mask8 operator<(Ints8 a, Ints8 b) {
    return b > a;
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd

#endif
