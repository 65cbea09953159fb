// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Eigenvalues of small symmetric matrices, by Jacobi's rotations.

#include <array>
#include <cstddef>
#include <vector>

namespace openfab::mechanics {

struct Eigen {
    std::vector<double> values;   ///< rising
    std::vector<double> vectors;  ///< [value][component]
};
/// `matrix`: [n][n].
Eigen eigen_of(std::vector<double> matrix, size_t n);

/// Of a stress xx, yy, zz, yz, xz, xy, rising.
std::array<double, 3> principal_of(const std::array<double, 6>& s);

}  // namespace openfab::mechanics
