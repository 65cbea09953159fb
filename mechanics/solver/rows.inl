// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The loops of rows.h, for the instruction set of the file that includes this. Included once in each.

#include <cstddef>
#include <utility>

#include "mechanics/solver/rows.h"
#include "simd/target.h"

namespace openfab::mechanics {
inline namespace OPENFAB_SIMD_ISA {

namespace {

/// Which of the four modes along y and z: 1, eta, zeta, eta zeta.
enum { kOne, kY, kZ, kYZ };

/// Bytes of a register.
#if defined(__AVX512F__)
constexpr size_t kRegister = 64;
#elif defined(__AVX2__)
constexpr size_t kRegister = 32;
#else
constexpr size_t kRegister = 16;
#endif

template <typename T, int C>
OPENFAB_INLINE void to_modes(int32_t n, const T* const* in, T* t) {
    const auto stride = static_cast<size_t>(n) + 1;
    for (int c = 0; c < C; ++c) {
        const T* __restrict a = in[c];
        const T* __restrict b = in[C + c];
        const T* __restrict d = in[2 * C + c];
        const T* __restrict e = in[3 * C + c];
        T* __restrict one = t + static_cast<size_t>(4 * c) * stride;
        T* __restrict y = one + stride;
        T* __restrict z = y + stride;
        T* __restrict yz = z + stride;
#pragma GCC ivdep
        for (int32_t x = 0; x <= n; ++x) {
            const T s0 = a[x] + b[x], d0 = b[x] - a[x];
            const T s1 = d[x] + e[x], d1 = e[x] - d[x];
            one[x] = s0 + s1;
            y[x] = d0 + d1;
            z[x] = s1 - s0;
            yz[x] = d1 - d0;
        }
    }
}

/// l: what the elements give to their left nodes, by mode; r: to their right ones, one further.
template <typename T, int C>
OPENFAB_INLINE void from_modes(int32_t n, const T* l, const T* r, T* const* out) {
    const auto stride = static_cast<size_t>(n) + 1;
    for (int c = 0; c < C; ++c) {
        T* __restrict a = out[c];
        T* __restrict b = out[C + c];
        T* __restrict d = out[2 * C + c];
        T* __restrict e = out[3 * C + c];
        const T* __restrict l0 = l + static_cast<size_t>(4 * c) * stride;
        const T* __restrict r0 = r + static_cast<size_t>(4 * c) * stride;
#pragma GCC ivdep
        for (int32_t x = 0; x <= n; ++x) {
            const auto i = static_cast<size_t>(x);
            const T one = l0[i] + r0[i];
            const T y = l0[stride + i] + r0[stride + i];
            const T z = l0[2 * stride + i] + r0[2 * stride + i];
            const T yz = l0[3 * stride + i] + r0[3 * stride + i];
            const T lower = one - z, upper = one + z, low = y - yz, high = y + yz;
            a[x] += lower - low;
            b[x] += lower + low;
            d[x] += upper - high;
            e[x] += upper + high;
        }
    }
}

/// `Count` numbers of a row, in a register or several.
template <typename T, size_t Count>
struct Lanes {
    typedef T Vector __attribute__((vector_size(Count * sizeof(T))));
};
template <typename T, size_t Count>
using Vector = typename Lanes<T, Count>::Vector;

template <size_t Count, typename T>
OPENFAB_INLINE Vector<T, Count> load(const T* from) {
    Vector<T, Count> out;
    __builtin_memcpy(&out, from, sizeof(out));
    return out;
}
template <size_t Count, typename T>
OPENFAB_INLINE void add_to(T* at, const Vector<T, Count>& v) {
    const Vector<T, Count> sum = load<Count>(at) + v;
    __builtin_memcpy(at, &sum, sizeof(sum));
}
/// The last of `before`, and all but the last of `now`.
template <typename V, size_t... Index>
OPENFAB_INLINE V moved_up(const V& before, const V& now, std::index_sequence<Index...>) {
    return __builtin_shufflevector(before, now, (sizeof...(Index) - 1 + Index)...);
}

template <typename T>
struct ElasticRow {
    ElementShape<T> shape;
    const float* first;
    const float* second;
    const T* modes;  ///< of to_modes
    size_t stride;
    T* const* out;
    T mean[6];
    T last[12] = {};  ///< what the element before gives to its right nodes, by mode
};

/// Adds what modes of a component give to the nodes from `at` on.
template <size_t Count, typename T>
OPENFAB_INLINE void add_modes(const Vector<T, Count>* modes, T* const* rows, size_t at) {
    const Vector<T, Count> lower = modes[kOne] - modes[kZ], upper = modes[kOne] + modes[kZ],
                           low = modes[kY] - modes[kYZ], high = modes[kY] + modes[kYZ];
    add_to<Count>(rows[0] + at, lower - low);
    add_to<Count>(rows[3] + at, lower + low);
    add_to<Count>(rows[6] + at, upper - high);
    add_to<Count>(rows[9] + at, upper + high);
}

/// Elements from `at` on, as many registers of them as there are whole ones; returns the next.
template <size_t Count, typename T>
OPENFAB_INLINE size_t elastic_lanes(size_t at, size_t n, ElasticRow<T>* row) {
    if (at + Count > n) return at;
    using Many = Vector<T, Count>;
    const T X = row->shape.x, Y = row->shape.y, Z = row->shape.z, V = row->shape.volume;
    const T whole = row->shape.whole, even_share = row->shape.even;
    const T third = T(1) / T(3), ninth = T(1) / T(9);
    const T e0 = row->mean[0], e1 = row->mean[1], e2 = row->mean[2];
    const T e3 = row->mean[3], e4 = row->mean[4], e5 = row->mean[5];
    Many before[12];
    for (size_t k = 0; k < 12; ++k)
        before[k] = Many{} + row->last[k];
    for (; at + Count <= n; at += Count) {
        const auto s = [&](size_t c, size_t m) OPENFAB_INLINE_LAMBDA {
            const T* t = row->modes + (4 * c + m) * row->stride + at;
            return load<Count>(t) + load<Count>(t + 1);
        };
        const auto d = [&](size_t c, size_t m) OPENFAB_INLINE_LAMBDA {
            const T* t = row->modes + (4 * c + m) * row->stride + at;
            return load<Count>(t + 1) - load<Count>(t);
        };
        const Many L = V * __builtin_convertvector(load<Count>(row->first + at), Many);
        const Many M = V * __builtin_convertvector(load<Count>(row->second + at), Many);
        const Many M2 = M + M, M3 = third * M, M9 = ninth * M;
        const Many B = whole * L - (T(2) * third) * (even_share * M);  // instead of lambda
        const Many dx0 = d(0, kOne), dxY = d(0, kY), dxZ = d(0, kZ), dxYZ = d(0, kYZ);
        const Many sxY = s(0, kY), sxZ = s(0, kZ), sxYZ = s(0, kYZ);
        const Many dy0 = d(1, kOne), dyY = d(1, kY), dyZ = d(1, kZ), dyYZ = d(1, kYZ);
        const Many syY = s(1, kY), syZ = s(1, kZ), syYZ = s(1, kYZ);
        const Many dz0 = d(2, kOne), dzY = d(2, kY), dzZ = d(2, kZ), dzYZ = d(2, kYZ);
        const Many szY = s(2, kY), szZ = s(2, kZ), szYZ = s(2, kYZ);
        // Normal strains by mode.
        const Many xx1 = X * dx0 + e0, yy1 = Y * syY + e1, zz1 = Z * szZ + e2;
        const Many xxY = X * dxY, xxZ = X * dxZ, xxYZ = X * dxYZ;
        const Many yyX = Y * dyY, yyZ = Y * syYZ, yyXZ = Y * dyYZ;
        const Many zzX = Z * dzZ, zzY = Z * szYZ, zzXY = Z * dzYZ;
        const Many bulk = L * (xx1 + yy1 + zz1);
        const Many sxx = bulk + M2 * xx1, syy = bulk + M2 * yy1, szz = bulk + M2 * zz1;
        const Many bX = B * (yyX + zzX), bY = B * (xxY + zzY), bZ = B * (xxZ + yyZ);
        const Many sxxY = third * (bY + M2 * xxY), szzY = third * (bY + M2 * zzY);
        const Many sxxZ = third * (bZ + M2 * xxZ), syyZ = third * (bZ + M2 * yyZ);
        const Many syyX = third * (bX + M2 * yyX), szzX = third * (bX + M2 * zzX);
        const Many high = ninth * (B + M2);
        const Many sxxYZ = high * xxYZ, syyXZ = high * yyXZ, szzXY = high * zzXY;
        // Shears by mode.
        const Many xy1 = M * (Y * sxY + X * dy0 + e5);
        const Many xyX = M3 * (Y * dxY), xyY = M3 * (X * dyY), xyZ = M3 * (Y * sxYZ + X * dyZ);
        const Many xyXZ = M9 * (Y * dxYZ), xyYZ = M9 * (X * dyYZ);
        const Many yz1 = M * (Z * syZ + Y * szY + e3);
        const Many yzX = M3 * (Z * dyZ + Y * dzY), yzY = M3 * (Z * syYZ), yzZ = M3 * (Y * szYZ);
        const Many yzXY = M9 * (Z * dyYZ), yzXZ = M9 * (Y * dzYZ);
        const Many xz1 = M * (Z * sxZ + X * dz0 + e4);
        const Many xzX = M3 * (Z * dxZ), xzY = M3 * (Z * sxYZ + X * dzY), xzZ = M3 * (X * dzZ);
        const Many xzXY = M9 * (Z * dxYZ), xzYZ = M9 * (X * dzYZ);
        // An element gives even - odd to its left nodes and even + odd to its right ones, one further.
        const auto sum = [&](size_t c, size_t m, const Many& even,
                             const Many& odd) OPENFAB_INLINE_LAMBDA {
            const Many right = even + odd;
            Many& of = before[4 * c + m];
            const Many out =
                (even - odd) + moved_up(of, right, std::make_index_sequence<Count>());
            of = right;
            return out;
        };
        const Many none{};
        const Many x_modes[4] = {sum(0, kOne, none, X * sxx),
                                 sum(0, kY, Y * xy1, X * sxxY + Y * xyX),
                                 sum(0, kZ, Z * xz1, X * sxxZ + Z * xzX),
                                 sum(0, kYZ, Y * xyZ + Z * xzY, X * sxxYZ + Y * xyXZ + Z * xzXY)};
        add_modes<Count>(x_modes, row->out, at);
        const Many y_modes[4] = {sum(1, kOne, none, X * xy1),
                                 sum(1, kY, Y * syy, Y * syyX + X * xyY),
                                 sum(1, kZ, Z * yz1, X * xyZ + Z * yzX),
                                 sum(1, kYZ, Y * syyZ + Z * yzY, Y * syyXZ + X * xyYZ + Z * yzXY)};
        add_modes<Count>(y_modes, row->out + 1, at);
        const Many z_modes[4] = {sum(2, kOne, none, X * xz1),
                                 sum(2, kY, Y * yz1, X * xzY + Y * yzX),
                                 sum(2, kZ, Z * szz, Z * szzX + X * xzZ),
                                 sum(2, kYZ, Z * szzY + Y * yzZ, Z * szzXY + X * xzYZ + Y * yzXZ)};
        add_modes<Count>(z_modes, row->out + 2, at);
    }
    for (size_t k = 0; k < 12; ++k)
        row->last[k] = before[k][Count - 1];
    return at;
}

template <typename T>
void elastic_row(const ElementShape<T>& shape, int32_t n, const float* first, const float* second,
                 const T* const* in, T* const* out, const T* mean, T* scratch) {
    const auto count = static_cast<size_t>(n);
    to_modes<T, 3>(n, in, scratch);
    ElasticRow<T> row{shape, first, second, scratch, count + 1, out, {}};
    for (size_t k = 0; mean && k < 6; ++k)
        row.mean[k] = mean[k];
    size_t at = elastic_lanes<kRegister / sizeof(T)>(0, count, &row);
    if constexpr (kRegister > 32) at = elastic_lanes<16 / sizeof(T)>(at, count, &row);
    at = elastic_lanes<1>(at, count, &row);
    // The last nodes have no element to their right.
    for (size_t c = 0; c < 3; ++c) {
        Vector<T, 1> modes[4];
        for (size_t m = 0; m < 4; ++m)
            modes[m] = Vector<T, 1>{T(0)} + row.last[4 * c + m];
        add_modes<1>(modes, out + c, at);
    }
}

template <typename T>
void scalar_row(const ElementShape<T>& shape, int32_t n, const float* first,
                const float* /*second*/, const T* const* in, T* const* out, const T* mean,
                T* scratch) {
    const auto stride = static_cast<size_t>(n) + 1;
    const T* __restrict t = scratch;
    T* __restrict l = scratch + 4 * stride;
    T* __restrict r = scratch + 8 * stride;
    to_modes<T, 1>(n, in, scratch);
    const T X = shape.x, Y = shape.y, Z = shape.z, V = shape.volume;
    const T third = T(1) / T(3), ninth = T(1) / T(9);
    const T e0 = mean ? mean[0] : T(0), e1 = mean ? mean[1] : T(0), e2 = mean ? mean[2] : T(0);
    const T xy = third * (X * X + Y * Y), xz = third * (X * X + Z * Z),
            yz = third * (Y * Y + Z * Z), xyz = ninth * (X * X + Y * Y + Z * Z);
    for (size_t k = 0; k < 4; ++k) {
        l[k * stride + static_cast<size_t>(n)] = T(0);
        r[k * stride] = T(0);
    }
#pragma GCC ivdep
    for (int32_t i = 0; i < n; ++i) {
        const auto p = static_cast<size_t>(i);
        const T K = V * static_cast<T>(first[i]);
        const auto put = [&](int m, T even, T odd) OPENFAB_INLINE_LAMBDA {
            const size_t at = static_cast<size_t>(m) * stride + p;
            l[at] = even - odd;
            r[at + 1] = even + odd;
        };
        const auto s = [&](int m) OPENFAB_INLINE_LAMBDA {
            const size_t at = static_cast<size_t>(m) * stride + p;
            return t[at] + t[at + 1];
        };
        const auto d = [&](int m) OPENFAB_INLINE_LAMBDA {
            const size_t at = static_cast<size_t>(m) * stride + p;
            return t[at + 1] - t[at];
        };
        put(kOne, T(0), X * K * (X * d(kOne) + e0));
        put(kY, Y * K * (Y * s(kY) + e1), xy * K * d(kY));
        put(kZ, Z * K * (Z * s(kZ) + e2), xz * K * d(kZ));
        put(kYZ, yz * K * s(kYZ), xyz * K * d(kYZ));
    }
    from_modes<T, 1>(n, l, r, out);
}

/// Gradients of modes times the stress times gradients, each component by itself.
void geometric_row(const ElementShape<double>& shape, int32_t n, const float* const* stress,
                   const double* const* in, double* const* out, double* scratch) {
    const auto stride = static_cast<size_t>(n) + 1;
    const double* __restrict t = scratch;
    double* __restrict l = scratch + 12 * stride;
    double* __restrict r = scratch + 24 * stride;
    to_modes<double, 3>(n, in, scratch);
    const double X = shape.x, Y = shape.y, Z = shape.z, V = shape.volume;
    const double third = 1.0 / 3, ninth = 1.0 / 9;
    for (size_t k = 0; k < 12; ++k) {
        l[k * stride + static_cast<size_t>(n)] = 0;
        r[k * stride] = 0;
    }
    for (size_t c = 0; c < 3; ++c) {
#pragma GCC ivdep
        for (int32_t i = 0; i < n; ++i) {
            const auto p = static_cast<size_t>(i);
            const auto s = [&](size_t m) OPENFAB_INLINE_LAMBDA {
                const size_t at = (4 * c + m) * stride + p;
                return t[at] + t[at + 1];
            };
            const auto d = [&](size_t m) OPENFAB_INLINE_LAMBDA {
                const size_t at = (4 * c + m) * stride + p;
                return t[at + 1] - t[at];
            };
            const auto put = [&](size_t m, double even, double odd) OPENFAB_INLINE_LAMBDA {
                const size_t at = (4 * c + m) * stride + p;
                l[at] = even - odd;
                r[at + 1] = even + odd;
            };
            const auto of = [&](int k) OPENFAB_INLINE_LAMBDA {
                return V * static_cast<double>(stress[k][i]);
            };
            const double xx = X * X * of(0), yy = Y * Y * of(1), zz = Z * Z * of(2);
            const double yz = Y * Z * of(3), xz = X * Z * of(4), xy = X * Y * of(5);
            const double x1 = d(kOne), y1 = s(kY), z1 = s(kZ);
            const double xy1 = d(kY), xz1 = d(kZ), yz1 = s(kYZ), xyz1 = d(kYZ);
            put(kOne, 0, xx * x1 + xy * y1 + xz * z1);
            put(kY, xy * x1 + yy * y1 + yz * z1, third * ((xx + yy) * xy1 + xz * yz1 + yz * xz1));
            put(kZ, xz * x1 + yz * y1 + zz * z1, third * ((xx + zz) * xz1 + xy * yz1 + yz * xy1));
            put(kYZ, third * ((yy + zz) * yz1 + xy * xz1 + xz * xy1),
                ninth * (xx + yy + zz) * xyz1);
        }
    }
    from_modes<double, 3>(n, l, r, out);
}

/// `Lanes` nodes of a row from x on; their sums stay in registers. The blocks of neighbours before the node are theirs,
/// transposed.
template <int C, int Lanes>
OPENFAB_INLINE void stencil_lanes(size_t x, size_t stride, const float* const* blocks,
                                  const float* const* in, float* const* out) {
    constexpr int kSelf = 13;
    float sum[C][Lanes] = {};
    for (int o = 0; o < 27; ++o) {
        if (!blocks[o]) continue;
        const float* a = blocks[o] + x;
        const size_t row = o < kSelf ? stride : C * stride, column = o < kSelf ? C * stride : stride;
        for (size_t c = 0; c < C; ++c) {
            const float* r = a + c * row;
            for (size_t k = 0; k < Lanes; ++k) {
                float product = r[k] * in[o * C][x + k];
                for (size_t d = 1; d < C; ++d)
                    product += r[d * column + k] * in[static_cast<size_t>(o * C) + d][x + k];
                sum[c][k] += product;
            }
        }
    }
    for (size_t c = 0; c < C; ++c)
        for (size_t k = 0; k < Lanes; ++k)
            out[c][x + k] = sum[c][k];
}

template <int C>
void stencil_row(int32_t n, size_t stride, const float* const* blocks, const float* const* in,
                 float* const* out) {
    const auto count = static_cast<size_t>(n);
    size_t x = 0;
    for (; x + 16 <= count; x += 16)
        stencil_lanes<C, 16>(x, stride, blocks, in, out);
    for (; x + 4 <= count; x += 4)
        stencil_lanes<C, 4>(x, stride, blocks, in, out);
    for (; x < count; ++x)
        stencil_lanes<C, 1>(x, stride, blocks, in, out);
}

void smooth_first(size_t n, float add, const float* w, const float* b, const float* q, float* d,
                  float* x) {
    if (!q) {
#pragma GCC ivdep
        for (size_t i = 0; i < n; ++i)
            x[i] = d[i] = add * (w[i] * b[i]);
        return;
    }
#pragma GCC ivdep
    for (size_t i = 0; i < n; ++i) {
        d[i] = add * (w[i] * (b[i] - q[i]));
        x[i] += d[i];
    }
}

void smooth_next(size_t n, float keep, float add, const float* w, const float* b, const float* q,
                 float* d, float* x) {
#pragma GCC ivdep
    for (size_t i = 0; i < n; ++i) {
        d[i] = keep * d[i] + add * (w[i] * (b[i] - q[i]));
        x[i] += d[i];
    }
}

template <typename A, typename B>
double dot(size_t n, const A* a, const B* b) {
    double lane[8] = {};
    size_t i = 0;
    for (; i + 8 <= n; i += 8)
        for (size_t k = 0; k < 8; ++k)
            lane[k] += static_cast<double>(a[i + k]) * static_cast<double>(b[i + k]);
    for (; i < n; ++i)
        lane[i % 8] += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) +
           ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

}  // namespace

extern const RowKernels kRowKernels;
const RowKernels kRowKernels{elastic_row<float>, elastic_row<double>, scalar_row<float>,
                             scalar_row<double>, geometric_row,       stencil_row<3>,
                             stencil_row<1>, smooth_first, smooth_next,    dot<double, double>, dot<float, double>,
                             dot<float, float>};

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::mechanics
