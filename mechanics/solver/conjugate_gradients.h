// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solves A x = b by conjugate gradients in doubles.

#include <functional>

#include "mechanics/solver/multigrid.h"

namespace openfab::mechanics {

struct SolveOptions {
    double tolerance = 1e-6;  ///< of the residual's norm to that of b
    int most_iterations = 400;
    MultigridOptions multigrid;
    /// Called after each iteration with its number and residual; false stops.
    std::function<bool(int, double)> progress;
};

struct SolveReport {
    int iterations = 0;
    double residual = 0;  ///< of A x - b, computed from x at the end, relative to b
    bool converged = false;
    bool stopped = false;  ///< by `progress`
};

/// `x` is the first guess and becomes the solution. Of a singular A, b must be in its range, as forces
/// of strains are.
template <int C>
SolveReport solve(const ElementOperator<C>& a, Multigrid<C>* preconditioner, Field<double, C>* b,
                  Field<double, C>* x, const SolveOptions& options);

/// What `solve` takes, fields and multigrid.
template <int C>
int64_t solver_bytes(const Grid& grid);

}  // namespace openfab::mechanics
