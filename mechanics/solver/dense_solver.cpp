// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/dense_solver.h"

#include <cmath>

namespace openfab::mechanics {

DenseSolver::DenseSolver(std::vector<double> a, size_t n, double vanishes)
    : n_(n), l_(std::move(a)) {
    std::vector<double> diagonal(n);
    for (size_t i = 0; i < n; ++i)
        diagonal[i] = l_[i * n + i];
    for (size_t j = 0; j < n; ++j) {
        double pivot = l_[j * n + j];
        for (size_t k = 0; k < j; ++k)
            pivot -= l_[j * n + k] * l_[j * n + k];
        const bool gone = !(pivot > vanishes * diagonal[j]);
        const double root = gone ? 0 : std::sqrt(pivot);
        l_[j * n + j] = root;
        for (size_t i = j + 1; i < n; ++i) {
            double sum = l_[i * n + j];
            for (size_t k = 0; k < j; ++k)
                sum -= l_[i * n + k] * l_[j * n + k];
            l_[i * n + j] = gone ? 0 : sum / root;
        }
    }
}

void DenseSolver::solve(double* x) const {
    for (size_t i = 0; i < n_; ++i) {
        double sum = x[i];
        for (size_t k = 0; k < i; ++k)
            sum -= l_[i * n_ + k] * x[k];
        const double root = l_[i * n_ + i];
        x[i] = root > 0 ? sum / root : 0;
    }
    for (size_t i = n_; i-- > 0;) {
        double sum = x[i];
        for (size_t k = i + 1; k < n_; ++k)
            sum -= l_[k * n_ + i] * x[k];
        const double root = l_[i * n_ + i];
        x[i] = root > 0 ? sum / root : 0;
    }
}

}  // namespace openfab::mechanics
