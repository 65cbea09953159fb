// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The effective stiffness and conductivity of a periodic cell.

#include <array>
#include <functional>
#include <vector>

#include "mechanics/solver/conjugate_gradients.h"

namespace openfab::mechanics {

template <int N>
using SquareMatrix = std::array<std::array<double, N>, N>;
/// Of xx, yy, zz, yz, xz, xy with engineering shears (Voigt's notation).
using Stiffness = SquareMatrix<6>;

struct HomogeniseOptions {
    SolveOptions solve;
    /// Called with the case, the iteration and the residual; false stops.
    std::function<bool(int, int, double)> progress;
};

template <int N>
struct Homogenised {
    SquareMatrix<N> tensor{};
    std::array<SolveReport, N> reports{};
    bool stopped = false;

    bool converged() const;
    double worst_residual() const;
    int most_iterations() const;
};

/// `values`: lambda and mu, normalised. The tensor is in their unit.
Homogenised<6> homogenise_stiffness(const Grid& grid, const ElementValues& values,
                                    const HomogeniseOptions& options);
Homogenised<3> homogenise_conductivity(const Grid& grid, const ElementValues& values,
                                       const HomogeniseOptions& options);

}  // namespace openfab::mechanics
