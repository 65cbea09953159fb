// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Geometric multigrid as a preconditioner: one symmetric V-cycle in floats, smoothed by Chebyshev
// polynomials, solved directly on the coarsest grid; with a second coarse space where stiff bodies are
// joined by soft material.

#include <memory>
#include <vector>

#include "mechanics/solver/dense_solver.h"
#include "mechanics/solver/stencil.h"
#include "mechanics/solver/stiff_bodies.h"

namespace openfab::mechanics {

struct MultigridOptions {
    int smooth_fine = 4;    ///< degree of the polynomial before and after the coarser grid
    int smooth_coarse = 3;  ///< the same below the finest grid
    double range = 30;      ///< of eigenvalues that are smoothed: the largest to a share of it
    bool bodies = true;     ///< solve for motions of stiff bodies among soft material
};

template <int C>
class Multigrid {
  public:
    /// `fine` outlives it.
    Multigrid(const ElementOperator<C>& fine, const MultigridOptions& options);
    ~Multigrid();

    /// z = M r; r is of doubles, and scaled into floats.
    const Field<float, C>& apply(const Field<double, C>& r);
    /// The same where the norm of r is known; `product` becomes the sum of z r, unless null.
    const Field<float, C>& apply(const Field<double, C>& r, double size, double* product);

    /// Takes the largest eigenvalues for larger than was found, where the cycle turned out not to be
    /// positive.
    void widen();
    int levels() const;
    int64_t bytes() const;
    /// What the multigrid of such a grid takes.
    static int64_t needed_bytes(const Grid& grid);

  private:
    struct Level;
    void cycle(size_t level);
    template <typename Operator>
    void cycle_with(const Operator& a, size_t level, int degree);
    template <typename Operator>
    double largest_eigenvalue(const Operator& a, Level* level) const;
    template <typename Operator>
    void smooth(const Operator& a, Level* level, int degree, bool from_zero) const;
    void solve_coarsest();

    const ElementOperator<C>& fine_;
    MultigridOptions options_;
    std::vector<std::unique_ptr<Level>> levels_;
    DenseSolver coarsest_;
    std::unique_ptr<StiffBodies<C>> bodies_;  ///< if there are any
};

}  // namespace openfab::mechanics
