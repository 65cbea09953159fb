// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace openfab::mechanics {

/// A Cholesky factor of a symmetric matrix that may be singular: unknowns whose pivot vanishes stay 0.
class DenseSolver {
  public:
    DenseSolver() = default;
    /// A pivot vanishes that is below such a share of its diagonal.
    DenseSolver(std::vector<double> matrix, size_t n, double vanishes);
    void solve(double* x) const;
    size_t size() const { return n_; }

  private:
    size_t n_ = 0;
    std::vector<double> l_;
};

}  // namespace openfab::mechanics
