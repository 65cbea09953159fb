// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The registers of SSE4.1: four lanes, and pairs of them for eight. Part of vectors.h.

#include <cstdint>
#include <cstring>

#include "simd/intrinsics.h"
#include "simd/target.h"

#if !defined(__AVX2__)

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

/// All ones or all zeros in each lane.
struct Mask4 {
    __m128 v;

    static OPENFAB_INLINE Mask4 from_bits(uint32_t bits) {
        const __m128i lane = _mm_setr_epi32(1, 2, 4, 8);
        const __m128i all = _mm_set1_epi32(static_cast<int32_t>(bits));
        return {_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(all, lane), lane))};
    }
    static OPENFAB_INLINE Mask4 all() { return {_mm_castsi128_ps(_mm_set1_epi32(-1))}; }
};
OPENFAB_INLINE Mask4 operator&(Mask4 a, Mask4 b) {
    return {_mm_and_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask4 operator|(Mask4 a, Mask4 b) {
    return {_mm_or_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask4 andnot(Mask4 a, Mask4 b) {
    return {_mm_andnot_ps(a.v, b.v)};
}
OPENFAB_INLINE uint32_t bits(Mask4 a) {
    return static_cast<uint32_t>(_mm_movemask_ps(a.v));
}
OPENFAB_INLINE bool any(Mask4 a) {
    return bits(a) != 0;
}

struct Ints4 {
    static constexpr int kLanes = 4;
    using Register = int32_t __attribute__((vector_size(16)));
    /// Arithmetic uses these, whose overflow is defined.
    using Wrapping = uint32_t __attribute__((vector_size(16)));
    Register v;

    Ints4() = default;
    OPENFAB_INLINE Ints4(Register all) : v(all) {}
    OPENFAB_INLINE Ints4(__m128i all) : v(reinterpret_cast<Register>(all)) {}
    OPENFAB_INLINE Ints4(int32_t x) : Ints4(_mm_set1_epi32(x)) {}
    OPENFAB_INLINE __m128i raw() const { return reinterpret_cast<__m128i>(v); }
    OPENFAB_INLINE int32_t lane(int l) const { return v[l]; }

    static OPENFAB_INLINE Ints4 load(const int32_t* p) {
        return _mm_load_si128(reinterpret_cast<const __m128i*>(p));
    }
    /// Converts 4 numbers.
    static OPENFAB_INLINE Ints4 load_unaligned(const uint16_t* p) {
        return _mm_cvtepu16_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
    }
    static OPENFAB_INLINE Ints4 load_unaligned(const uint8_t* p) {
        int32_t bytes;
        std::memcpy(&bytes, p, sizeof bytes);
        return _mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes));
    }
    /// Returns f(0), f(1), …
    template <typename F>
    static OPENFAB_INLINE Ints4 generate(const F& f) {
        return Register{f(0), f(1), f(2), f(3)};
    }
    /// Returns 0, 1, 2, …
    static OPENFAB_INLINE Ints4 lane_numbers() { return Register{0, 1, 2, 3}; }

    OPENFAB_INLINE Ints4& operator+=(Ints4 b) {
        v = Register(Wrapping(v) + Wrapping(b.v));
        return *this;
    }
    OPENFAB_INLINE Ints4& operator-=(Ints4 b) {
        v = Register(Wrapping(v) - Wrapping(b.v));
        return *this;
    }
};
OPENFAB_INLINE Ints4 operator+(Ints4 a, Ints4 b) {
    return Ints4::Register(Ints4::Wrapping(a.v) + Ints4::Wrapping(b.v));
}
OPENFAB_INLINE Ints4 operator-(Ints4 a, Ints4 b) {
    return Ints4::Register(Ints4::Wrapping(a.v) - Ints4::Wrapping(b.v));
}
OPENFAB_INLINE Ints4 operator*(Ints4 a, Ints4 b) {
    return Ints4::Register(Ints4::Wrapping(a.v) * Ints4::Wrapping(b.v));
}
OPENFAB_INLINE Ints4 operator&(Ints4 a, Ints4 b) {
    return a.v & b.v;
}
OPENFAB_INLINE Ints4 operator|(Ints4 a, Ints4 b) {
    return a.v | b.v;
}
OPENFAB_INLINE Ints4 operator>>(Ints4 a, int by) {
    return a.v >> by;
}
OPENFAB_INLINE Ints4 min(Ints4 a, Ints4 b) {
    return _mm_min_epi32(a.raw(), b.raw());
}
OPENFAB_INLINE Ints4 max(Ints4 a, Ints4 b) {
    return _mm_max_epi32(a.raw(), b.raw());
}
OPENFAB_INLINE void store(int32_t* p, Ints4 a) {
    _mm_store_si128(reinterpret_cast<__m128i*>(p), a.raw());
}
/// Stores the low byte of each lane.
OPENFAB_INLINE void store_low_bytes(uint8_t* p, Ints4 a) {
    const __m128i packed = _mm_shuffle_epi8(a.raw(), _mm_set1_epi32(0x0c080400));
    const int32_t bytes = _mm_cvtsi128_si32(packed);
    std::memcpy(p, &bytes, sizeof bytes);
}

struct Uints4 {
    using Register = uint32_t __attribute__((vector_size(16)));
    Register v;

    OPENFAB_INLINE explicit Uints4(Register all) : v(all) {}
    OPENFAB_INLINE explicit Uints4(uint32_t x) : v(Register{} + x) {}
    OPENFAB_INLINE explicit Uints4(Ints4 a) : v(reinterpret_cast<Register>(a.v)) {}
};
OPENFAB_INLINE Uints4 operator*(Uints4 a, Uints4 b) {
    return Uints4(a.v * b.v);
}
OPENFAB_INLINE Uints4 operator^(Uints4 a, Uints4 b) {
    return Uints4(a.v ^ b.v);
}
OPENFAB_INLINE Uints4 operator>>(Uints4 a, Uints4 b) {
    return Uints4(a.v >> b.v);
}
OPENFAB_INLINE Ints4 as_ints(Uints4 a) {
    return reinterpret_cast<Ints4::Register>(a.v);
}

struct Floats4 {
    static constexpr int kLanes = 4;
    using Mask = Mask4;
    using Ints = Ints4;
    __m128 v;

    Floats4() = default;
    OPENFAB_INLINE Floats4(__m128 all) : v(all) {}
    OPENFAB_INLINE Floats4(float x) : v(_mm_set1_ps(x)) {}

    static OPENFAB_INLINE Floats4 load(const float* p) { return _mm_load_ps(p); }
    static OPENFAB_INLINE Floats4 load_unaligned(const float* p) { return _mm_loadu_ps(p); }

    OPENFAB_INLINE Floats4& operator+=(Floats4 b) {
        v = _mm_add_ps(v, b.v);
        return *this;
    }
    OPENFAB_INLINE Floats4& operator-=(Floats4 b) {
        v = _mm_sub_ps(v, b.v);
        return *this;
    }
};
OPENFAB_INLINE Floats4 operator+(Floats4 a, Floats4 b) {
    return _mm_add_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 operator-(Floats4 a, Floats4 b) {
    return _mm_sub_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 operator*(Floats4 a, Floats4 b) {
    return _mm_mul_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 operator/(Floats4 a, Floats4 b) {
    return _mm_div_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 min(Floats4 a, Floats4 b) {
    return _mm_min_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 max(Floats4 a, Floats4 b) {
    return _mm_max_ps(a.v, b.v);
}
OPENFAB_INLINE Floats4 sqrt(Floats4 a) {
    return _mm_sqrt_ps(a.v);
}
OPENFAB_INLINE Floats4 floor(Floats4 a) {
    return _mm_floor_ps(a.v);
}
OPENFAB_INLINE Floats4 ceil(Floats4 a) {
    return _mm_ceil_ps(a.v);
}
OPENFAB_INLINE Floats4 absolute(Floats4 a) {
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v);
}
OPENFAB_INLINE void store(float* p, Floats4 a) {
    _mm_store_ps(p, a.v);
}
OPENFAB_INLINE void store_unaligned(float* p, Floats4 a) {
    _mm_storeu_ps(p, a.v);
}
OPENFAB_INLINE Ints4 as_ints(Floats4 a) {
    return _mm_castps_si128(a.v);
}
OPENFAB_INLINE Floats4 as_floats(Ints4 a) {
    return _mm_castsi128_ps(a.raw());
}
OPENFAB_INLINE Floats4 to_floats(Ints4 a) {
    return _mm_cvtepi32_ps(a.raw());
}
OPENFAB_INLINE Ints4 to_ints(Floats4 a) {
    return _mm_cvttps_epi32(a.v);
}
OPENFAB_INLINE Ints4 round_to_ints(Floats4 a) {
    return _mm_cvtps_epi32(a.v);
}
OPENFAB_INLINE Mask4 operator<(Floats4 a, Floats4 b) {
    return {_mm_cmplt_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask4 operator<=(Floats4 a, Floats4 b) {
    return {_mm_cmple_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask4 operator==(Floats4 a, Floats4 b) {
    return {_mm_cmpeq_ps(a.v, b.v)};
}
OPENFAB_INLINE Mask4 operator>(Floats4 a, Floats4 b) {
    return b < a;
}
OPENFAB_INLINE Mask4 operator>=(Floats4 a, Floats4 b) {
    return b <= a;
}
OPENFAB_INLINE Mask4 operator>(Ints4 a, Ints4 b) {
    return {_mm_castsi128_ps(_mm_cmpgt_epi32(a.raw(), b.raw()))};
}
OPENFAB_INLINE Mask4 operator==(Ints4 a, Ints4 b) {
    return {_mm_castsi128_ps(_mm_cmpeq_epi32(a.raw(), b.raw()))};
}
OPENFAB_INLINE Mask4 operator<(Ints4 a, Ints4 b) {
    return b > a;
}
OPENFAB_INLINE Floats4 select(Mask4 mask, Floats4 a, Floats4 b) {
    return _mm_blendv_ps(b.v, a.v, mask.v);
}
OPENFAB_INLINE Floats4 masked(Mask4 mask, Floats4 a) {
    return _mm_and_ps(mask.v, a.v);
}
OPENFAB_INLINE Floats4 andnot(Mask4 mask, Floats4 a) {
    return _mm_andnot_ps(mask.v, a.v);
}
OPENFAB_INLINE Ints4 select(Mask4 mask, Ints4 a, Ints4 b) {
    return as_ints(select(mask, as_floats(a), as_floats(b)));
}
OPENFAB_INLINE Ints4 masked(Mask4 mask, Ints4 a) {
    return as_ints(masked(mask, as_floats(a)));
}
/// Returns -1 or 0 in each lane.
OPENFAB_INLINE Ints4 as_ints(Mask4 mask) {
    return _mm_castps_si128(mask.v);
}

// Pairs.

struct Mask8 {
    Mask4 lo, hi;

    static OPENFAB_INLINE Mask8 from_bits(uint32_t bits) {
        return {Mask4::from_bits(bits), Mask4::from_bits(bits >> 4)};
    }
};
OPENFAB_INLINE Mask8 operator&(Mask8 a, Mask8 b) {
    return {a.lo & b.lo, a.hi & b.hi};
}
OPENFAB_INLINE Mask8 operator|(Mask8 a, Mask8 b) {
    return {a.lo | b.lo, a.hi | b.hi};
}
OPENFAB_INLINE Mask8 andnot(Mask8 a, Mask8 b) {
    return {andnot(a.lo, b.lo), andnot(a.hi, b.hi)};
}
OPENFAB_INLINE uint32_t bits(Mask8 a) {
    return bits(a.lo) | bits(a.hi) << 4;
}
OPENFAB_INLINE bool any(Mask8 a) {
    return bits(a) != 0;
}

struct Ints8 {
    static constexpr int kLanes = 8;
    Ints4 lo, hi;

    Ints8() = default;
    OPENFAB_INLINE Ints8(Ints4 low, Ints4 high) : lo(low), hi(high) {}
    OPENFAB_INLINE Ints8(int32_t x) : lo(x), hi(x) {}

    static OPENFAB_INLINE Ints8 load(const int32_t* p) {
        return {Ints4::load(p), Ints4::load(p + 4)};
    }
};
OPENFAB_INLINE void store(int32_t* p, Ints8 a) {
    store(p, a.lo);
    store(p + 4, a.hi);
}
OPENFAB_INLINE Ints8 select(Mask8 mask, Ints8 a, Ints8 b) {
    return {select(mask.lo, a.lo, b.lo), select(mask.hi, a.hi, b.hi)};
}

struct Floats8 {
    static constexpr int kLanes = 8;
    using Mask = Mask8;
    using Ints = Ints8;
    Floats4 lo, hi;

    Floats8() = default;
    OPENFAB_INLINE Floats8(Floats4 low, Floats4 high) : lo(low), hi(high) {}
    OPENFAB_INLINE Floats8(float x) : lo(x), hi(x) {}

    static OPENFAB_INLINE Floats8 load(const float* p) {
        return {Floats4::load(p), Floats4::load(p + 4)};
    }
    /// Joins kLanes / 8 vectors of eight lanes.
    static OPENFAB_INLINE Floats8 join(const Floats8* parts) { return parts[0]; }
};
OPENFAB_INLINE Floats8 operator+(Floats8 a, Floats8 b) {
    return {a.lo + b.lo, a.hi + b.hi};
}
OPENFAB_INLINE Floats8 operator-(Floats8 a, Floats8 b) {
    return {a.lo - b.lo, a.hi - b.hi};
}
OPENFAB_INLINE Floats8 operator*(Floats8 a, Floats8 b) {
    return {a.lo * b.lo, a.hi * b.hi};
}
OPENFAB_INLINE Floats8 operator/(Floats8 a, Floats8 b) {
    return {a.lo / b.lo, a.hi / b.hi};
}
OPENFAB_INLINE Floats8 min(Floats8 a, Floats8 b) {
    return {min(a.lo, b.lo), min(a.hi, b.hi)};
}
OPENFAB_INLINE Floats8 max(Floats8 a, Floats8 b) {
    return {max(a.lo, b.lo), max(a.hi, b.hi)};
}
OPENFAB_INLINE Floats8 sqrt(Floats8 a) {
    return {sqrt(a.lo), sqrt(a.hi)};
}
OPENFAB_INLINE Floats8 absolute(Floats8 a) {
    return {absolute(a.lo), absolute(a.hi)};
}
OPENFAB_INLINE Floats8 about_mul_add(Floats8 a, Floats8 b, Floats8 c) {
    return a * b + c;
}
OPENFAB_INLINE Floats8 about_mul_sub(Floats8 a, Floats8 b, Floats8 c) {
    return a * b - c;
}
OPENFAB_INLINE void store(float* p, Floats8 a) {
    store(p, a.lo);
    store(p + 4, a.hi);
}
OPENFAB_INLINE Ints8 round_to_ints(Floats8 a) {
    return {round_to_ints(a.lo), round_to_ints(a.hi)};
}
OPENFAB_INLINE Mask8 operator<(Floats8 a, Floats8 b) {
    return {a.lo < b.lo, a.hi < b.hi};
}
OPENFAB_INLINE Mask8 operator<=(Floats8 a, Floats8 b) {
    return {a.lo <= b.lo, a.hi <= b.hi};
}
OPENFAB_INLINE Mask8 operator==(Floats8 a, Floats8 b) {
    return {a.lo == b.lo, a.hi == b.hi};
}
OPENFAB_INLINE Floats8 select(Mask8 mask, Floats8 a, Floats8 b) {
    return {select(mask.lo, a.lo, b.lo), select(mask.hi, a.hi, b.hi)};
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd

#endif
