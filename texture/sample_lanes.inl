// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Lanes of floats and ints, as many as a register of the instruction set holds: 8 or 4. Arithmetic
// and comparisons are the compiler's own for such types. Part of look_up.inl.

#define OPENFAB_INLINE inline __attribute__((always_inline))

#if defined(__AVX2__)
constexpr int32_t kLanes = 8;
#else
constexpr int32_t kLanes = 4;
#endif
using F = float __attribute__((vector_size(kLanes * sizeof(float))));
using I = int32_t __attribute__((vector_size(kLanes * sizeof(int32_t))));

OPENFAB_INLINE F splat(float x) {
    return F{} + x;
}
OPENFAB_INLINE I splat(int32_t x) {
    return I{} + x;
}
OPENFAB_INLINE F as_floats(I a) {
    return reinterpret_cast<F>(a);
}
OPENFAB_INLINE I as_ints(F a) {
    return reinterpret_cast<I>(a);
}
OPENFAB_INLINE F to_floats(I a) {
    return __builtin_convertvector(a, F);
}
OPENFAB_INLINE F masked(I mask, F a) {
    return as_floats(mask & as_ints(a));
}
OPENFAB_INLINE F absolute(F a) {
    return as_floats(as_ints(a) & 0x7fffffff);
}
template <typename V, typename T>
OPENFAB_INLINE V load(const T* p) {
    V out;
    std::memcpy(&out, p, sizeof(out));
    return out;
}
template <typename T, typename V>
OPENFAB_INLINE void store(T* p, V a) {
    std::memcpy(p, &a, sizeof(a));
}

// larger: a > b ? a : b. smaller: a < b ? a : b. Both give b where either is NaN.
// to_ints: towards 0. signs: bit i is the sign of lane i.
#if defined(__AVX2__)
OPENFAB_INLINE F larger(F a, F b) {
    return _mm256_max_ps(a, b);
}
OPENFAB_INLINE F smaller(F a, F b) {
    return _mm256_min_ps(a, b);
}
OPENFAB_INLINE F floor(F a) {
    return _mm256_floor_ps(a);
}
OPENFAB_INLINE F ceil(F a) {
    return _mm256_ceil_ps(a);
}
OPENFAB_INLINE F sqrt(F a) {
    return _mm256_sqrt_ps(a);
}
OPENFAB_INLINE I to_ints(F a) {
    return reinterpret_cast<I>(_mm256_cvttps_epi32(a));
}
OPENFAB_INLINE uint32_t signs(I mask) {
    return static_cast<uint32_t>(_mm256_movemask_ps(as_floats(mask)));
}
#else
OPENFAB_INLINE F larger(F a, F b) {
    return _mm_max_ps(a, b);
}
OPENFAB_INLINE F smaller(F a, F b) {
    return _mm_min_ps(a, b);
}
OPENFAB_INLINE F floor(F a) {
    return _mm_floor_ps(a);
}
OPENFAB_INLINE F ceil(F a) {
    return _mm_ceil_ps(a);
}
OPENFAB_INLINE F sqrt(F a) {
    return _mm_sqrt_ps(a);
}
OPENFAB_INLINE I to_ints(F a) {
    return reinterpret_cast<I>(_mm_cvttps_epi32(a));
}
OPENFAB_INLINE uint32_t signs(I mask) {
    return static_cast<uint32_t>(_mm_movemask_ps(as_floats(mask)));
}
#endif

/// Clamps: x > lo ? (x < hi ? x : hi) : lo, for lo <= hi.
OPENFAB_INLINE F bound(F x, float lo, float hi) {
    return smaller(larger(x, splat(lo)), splat(hi));
}
OPENFAB_INLINE I bound(I x, I lo, I hi) {
    const I above = x > lo ? x : lo;
    return above < hi ? above : hi;
}

/// Loads `from[at[i]]` into lane i.
OPENFAB_INLINE F gather(const float* from, const int32_t* at) {
#if defined(__AVX2__)
    return F{from[at[0]], from[at[1]], from[at[2]], from[at[3]],
             from[at[4]], from[at[5]], from[at[6]], from[at[7]]};
#else
    return F{from[at[0]], from[at[1]], from[at[2]], from[at[3]]};
#endif
}

/// Loads two floats from each of two addresses.
OPENFAB_INLINE __m128 load_two(const float* from, int32_t a, int32_t b) {
    const __m128 low = _mm_castpd_ps(_mm_load_sd(reinterpret_cast<const double*>(from + a)));
    return _mm_loadh_pi(low, reinterpret_cast<const __m64*>(from + b));
}

/// Loads `from[at[i]]` and the float behind it.
OPENFAB_INLINE void load_pairs(const float* from, const int32_t* at, F* first, F* second) {
#if defined(__AVX2__)
    const F a = _mm256_set_m128(load_two(from, at[4], at[5]), load_two(from, at[0], at[1]));
    const F b = _mm256_set_m128(load_two(from, at[6], at[7]), load_two(from, at[2], at[3]));
    *first = _mm256_shuffle_ps(a, b, 0x88);
    *second = _mm256_shuffle_ps(a, b, 0xdd);
#else
    const F a = load_two(from, at[0], at[1]), b = load_two(from, at[2], at[3]);
    *first = _mm_shuffle_ps(a, b, 0x88);
    *second = _mm_shuffle_ps(a, b, 0xdd);
#endif
}

/// Loads `from[at[i]]` and the three floats behind it.
OPENFAB_INLINE void load_quads(const float* from, const int32_t* at, F* columns) {
    F r[4];
#if defined(__AVX2__)
    for (int32_t i = 0; i < 4; ++i)
        r[i] = _mm256_set_m128(_mm_loadu_ps(from + at[i + 4]), _mm_loadu_ps(from + at[i]));
    const F a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpacklo_ps(r[2], r[3]);
    const F c = _mm256_unpackhi_ps(r[0], r[1]), d = _mm256_unpackhi_ps(r[2], r[3]);
    columns[0] = _mm256_shuffle_ps(a, b, 0x44);
    columns[1] = _mm256_shuffle_ps(a, b, 0xee);
    columns[2] = _mm256_shuffle_ps(c, d, 0x44);
    columns[3] = _mm256_shuffle_ps(c, d, 0xee);
#else
    for (int32_t i = 0; i < 4; ++i)
        r[i] = _mm_loadu_ps(from + at[i]);
    _MM_TRANSPOSE4_PS(r[0], r[1], r[2], r[3]);
    std::copy_n(r, 4, columns);
#endif
}
