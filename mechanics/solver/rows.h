// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The inner loops of the solver, a row of the grid at a time, compiled for several instruction sets.
// Each does the same operations on each number in the same order, so all give the same bits.

#include <cstddef>
#include <cstdint>

namespace openfab::mechanics {

/// Shape of an element: 2 / pitch along each axis; volume / 64, by which sums over corners become
/// integrals.
template <typename T>
struct ElementShape {
    T x, y, z, volume;
    T even = 1, whole = 0;  ///< of modes above the first: B-bar, or all of lambda
};

/// Applies the elements of a row: adds their nodal forces to the four rows of nodes around them.
///
/// Displacements of an element are a_m 1, xi, eta, zeta, xi eta, ... (eight modes a component), whose
/// derivatives are orthogonal, so that its 24 x 24 matrix is butterflies and a few products. Of a mode
/// above the first only the deviatoric part is stiff in bulk (B-bar), else soft materials lock; or all of it, as in
/// the hexahedra of other programs.
///
/// C = 3: `first` is lambda, `second` mu. C = 1: `first` is the conductivity, `second` is not read.
/// in and out: [4 rows: y, y+1, y at z+1, y+1 at z+1][C], nodes 0 ... n. `mean`: a strain (xx, yy, zz,
/// yz, xz, xy as engineering shears) or a gradient on top of it, times 8; or null. scratch: 12 C (n + 1).
template <typename T, int C>
using ElementRow = void (*)(const ElementShape<T>& shape, int32_t n, const float* first,
                            const float* second, const T* const* in, T* const* out, const T* mean,
                            T* scratch);

struct RowKernels {
    ElementRow<float, 3> elastic_float;
    ElementRow<double, 3> elastic_double;
    ElementRow<float, 1> scalar_float;
    ElementRow<double, 1> scalar_double;
    /// Adds what stresses of elements (xx, yy, zz, yz, xz, xy) do where nodes move, of three components;
    /// in and out as above.
    void (*geometric)(const ElementShape<double>& shape, int32_t n, const float* const* stress,
                      const double* const* in, double* const* out, double* scratch);
    /// out[c][x] = sum over o, c' of blocks[o][c][c'][x] in[o][c'][x], o of 27, of a row of a stencil; of the
    /// first 13 blocks[o][c'][c][x], as their neighbours keep them. blocks: [27], rows of numbers `stride`
    /// apart, null where there is no neighbour; in: [27][C].
    void (*stencil3)(int32_t n, size_t stride, const float* const* blocks, const float* const* in,
                     float* const* out);
    void (*stencil1)(int32_t n, size_t stride, const float* const* blocks, const float* const* in,
                     float* const* out);
    /// A step of a Chebyshev smoother, i of n: d = keep d + add w (b - q), x += d; the first has no d before it, and
    /// neither q nor x where it starts from zero (`q` null).
    void (*smooth_first)(size_t n, float add, const float* w, const float* b, const float* q,
                         float* d, float* x);
    void (*smooth_next)(size_t n, float keep, float add, const float* w, const float* b,
                        const float* q, float* d, float* x);
    /// Sum of a[i] b[i] in eight lanes.
    double (*dot_double)(size_t n, const double* a, const double* b);
    double (*dot_float_double)(size_t n, const float* a, const double* b);
    double (*dot_float)(size_t n, const float* a, const float* b);
};

/// Those of this machine's best set, up to `limit` (0 SSE4.1, 1 AVX2, 2 AVX-512).
const RowKernels& row_kernels(int limit = 2);

}  // namespace openfab::mechanics
