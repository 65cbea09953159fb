// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Transposes, and gathers.

#include <cstddef>
#include <cstdint>

#include "simd/intrinsics.h"
#include "simd/vectors.h"

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

#if defined(__AVX2__)
/// Transposes an 8 x 8 matrix of floats.
OPENFAB_INLINE void transpose8(const float* const* rows, size_t first, Floats8* columns) {
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
/// Transposes an 8 x 8 matrix of floats.
OPENFAB_INLINE void transpose8(const float* const* rows, size_t first, Floats8* columns) {
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
OPENFAB_INLINE void transpose(const float* const* rows, size_t first, Floats8* columns) {
    transpose8(rows, first, columns);
    transpose8(rows, first + 8, columns + 8);
}
#if defined(__AVX512F__)
OPENFAB_INLINE void transpose(const float* const* rows, size_t first, Floats16* columns) {
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

/// Loads `from[at[l]]` into lane l.
OPENFAB_INLINE Floats gather(const float* from, const int32_t* at) {
#if defined(__AVX2__)
    return _mm256_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]], from[at[4]],
                          from[at[5]], from[at[6]], from[at[7]]);
#else
    return _mm_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]]);
#endif
}

/// Loads two floats from each of two addresses.
OPENFAB_INLINE __m128 load_two(const float* from, int32_t a, int32_t b) {
    const __m128 low = _mm_castpd_ps(_mm_load_sd(reinterpret_cast<const double*>(from + a)));
    return _mm_loadh_pi(low, reinterpret_cast<const __m64*>(from + b));
}

/// Loads `from[at[l]]` and the float behind it.
OPENFAB_INLINE void load_pairs(const float* from, const int32_t* at, Floats* first,
                               Floats* second) {
#if defined(__AVX2__)
    const __m256 a = _mm256_set_m128(load_two(from, at[4], at[5]), load_two(from, at[0], at[1]));
    const __m256 b = _mm256_set_m128(load_two(from, at[6], at[7]), load_two(from, at[2], at[3]));
    *first = _mm256_shuffle_ps(a, b, 0x88);
    *second = _mm256_shuffle_ps(a, b, 0xdd);
#else
    const __m128 a = load_two(from, at[0], at[1]), b = load_two(from, at[2], at[3]);
    *first = _mm_shuffle_ps(a, b, 0x88);
    *second = _mm_shuffle_ps(a, b, 0xdd);
#endif
}

/// Loads `from[at[l]]` and the three floats behind it.
OPENFAB_INLINE void load_quads(const float* from, const int32_t* at, Floats* columns) {
#if defined(__AVX2__)
    __m256 r[4];
    for (int32_t i = 0; i < 4; ++i)
        r[i] = _mm256_set_m128(_mm_loadu_ps(from + at[i + 4]), _mm_loadu_ps(from + at[i]));
    const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpacklo_ps(r[2], r[3]);
    const __m256 c = _mm256_unpackhi_ps(r[0], r[1]), d = _mm256_unpackhi_ps(r[2], r[3]);
    columns[0] = _mm256_shuffle_ps(a, b, 0x44);
    columns[1] = _mm256_shuffle_ps(a, b, 0xee);
    columns[2] = _mm256_shuffle_ps(c, d, 0x44);
    columns[3] = _mm256_shuffle_ps(c, d, 0xee);
#else
    __m128 r[4];
    for (int32_t i = 0; i < 4; ++i)
        r[i] = _mm_loadu_ps(from + at[i]);
    _MM_TRANSPOSE4_PS(r[0], r[1], r[2], r[3]);
    for (int32_t i = 0; i < 4; ++i)
        columns[i] = r[i];
#endif
}

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd
