// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The operator of the finest grid: one hexahedron a voxel, no matrix.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "mechanics/solver/field.h"
#include "mechanics/solver/rows.h"

namespace openfab::mechanics {

/// Components of the unknown: displacement, and temperature or voltage.
constexpr int kElastic = 3, kScalar = 1;

/// What the elements of a grid are made of: [z][y][x]. Elastic: lambda and mu; scalar: the conductivity,
/// `second` empty. Void is 0. Divided by `unit`, the largest of them, so that floats suffice.
struct ElementValues {
    std::vector<float> first, second;
    double unit = 1;
    /// The volume of an element changes unevenly, as in hexahedra that are integrated in full; else evenly
    /// (B-bar), which does not lock.
    bool full = false;

    /// Does the division.
    void normalise();
    /// Undoes it, but for the rounding of floats.
    void restore();
};

/// Number of a degree of freedom: node [z][y][x] times C plus the component.
using FixedNodes = std::vector<int64_t>;

/// Called with the z of a plane.
using PlaneDone = std::function<void(int32_t)>;

template <int C>
class ElementOperator {
  public:
    /// `values` and `fixed` outlive it; fixed is sorted. Values of fixed unknowns are 0 in what it is
    /// applied to, and become 0 in what it gives.
    ElementOperator(const Grid& grid, const ElementValues* values, const FixedNodes* fixed);

    /// y = A x + forces of a mean strain (C = 3: 6 numbers) or gradient (3), unless null. Fills the ghosts
    /// of x, but does not change it. `done` is called once for each plane, several at once, when it is whole in y and
    /// nothing reads it in x any more: what comes next finds both in the cache.
    template <typename T>
    void apply(Field<T, C>* x, Field<T, C>* y, const double* mean = nullptr,
               const PlaneDone& done = nullptr) const;

    /// Sets 0 where fixed.
    template <typename T>
    void fix(Field<T, C>* x, int32_t z) const;
    template <typename T>
    void fix(Field<T, C>* x) const;

    /// 1 / diagonal of A; 0 where nothing is stiff, or fixed.
    void inverse_diagonal(Field<float, C>* out) const;

    /// The matrix of an element whose `first`, or whose `second`, is 1: [8 C][8 C], corners x fastest.
    static std::vector<double> element_matrix(const std::array<double, 3>& pitch_mm, int which,
                                              bool full = false);

    const Grid& grid() const { return grid_; }
    const ElementValues& values() const { return *values_; }
    const FixedNodes& fixed() const { return *fixed_; }
    /// Whether a node has a fixed component: bits of the components.
    uint8_t fixed_at(int32_t x, int32_t y, int32_t z) const;

  private:
    template <typename T>
    void add_row(int32_t y, int32_t z, const Field<T, C>& x, Field<T, C>* out, const T* mean,
                 T* scratch) const;
    /// Gives what elements gave to the ghosts of a plane to the nodes they stand for, and nothing to what is fixed.
    template <typename T>
    void finish(Field<T, C>* y, int32_t z) const;

    Grid grid_;
    const ElementValues* values_;
    const FixedNodes* fixed_;
    std::vector<int64_t> fixed_begin_;  ///< of each plane
};

template <typename T>
ElementShape<T> element_shape(const std::array<double, 3>& pitch_mm, bool full = false) {
    return {static_cast<T>(2 / pitch_mm[0]),
            static_cast<T>(2 / pitch_mm[1]),
            static_cast<T>(2 / pitch_mm[2]),
            static_cast<T>(pitch_mm[0] * pitch_mm[1] * pitch_mm[2] / 64),
            static_cast<T>(full ? 0 : 1),
            static_cast<T>(full ? 1 : 0)};
}

/// The kernel for a type and a number of components.
template <typename T, int C>
ElementRow<T, C> element_row() {
    const RowKernels& k = row_kernels();
    if constexpr (C == 3) {
        if constexpr (sizeof(T) == 4)
            return k.elastic_float;
        else
            return k.elastic_double;
    } else {
        if constexpr (sizeof(T) == 4)
            return k.scalar_float;
        else
            return k.scalar_double;
    }
}

/// Sum of a b over all nodes, the same for any number of threads; or over those of a plane.
template <typename A, typename B, int C>
double dot(const Field<A, C>& a, const Field<B, C>& b);
template <typename A, typename B, int C>
double dot(const Field<A, C>& a, const Field<B, C>& b, int32_t z);

}  // namespace openfab::mechanics
