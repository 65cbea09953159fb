// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The softest modes of a part that is held: how it gives way most easily, and where.

#include <functional>
#include <vector>

#include "mechanics/part/part_problem.h"

namespace openfab::mechanics {

struct Mode {
    double frequency_Hz = 0;
    double residual = 0;                 ///< of K x = w^2 M x, relative
    Vec3 moved_at_mm{};                  ///< where it moves most
    Vec3 moved{};                        ///< unit vector there
    Vec3 strained_at_mm{};               ///< where its stress is greatest, von Mises
    int64_t strained = -1;               ///< the element there
    std::array<double, 6> stress_MPa{};  ///< in its middle: xx, yy, zz, yz, xz, xy
    double von_mises_MPa = 0;            ///< at its worst corner
    int material = 0;                    ///< there
};

struct ModeOptions {
    size_t count = 6;
    SolveOptions solve;
    int most_sweeps = 30;
    double tolerance = 1e-3;  ///< of squared frequencies, between sweeps
    /// Called after each sweep with its number and the greatest change; false stops.
    std::function<bool(int, double)> progress;
};

struct Modes {
    std::vector<Mode> all;  ///< rising
    std::vector<float>
        weakness;  ///< [element]: the greatest von Mises stress of a mode of unit energy
    bool converged = false, stopped = false;
};

/// By subspace iteration: each sweep solves for a vector a mode by the preconditioned solver. `problem` has
/// what is held; loads are not looked at. Masses are those of densities, in g/cm3.
Modes softest_modes(PartProblem* problem, const ModeOptions& options);
int64_t modes_bytes(const Grid& grid, size_t count);

}  // namespace openfab::mechanics
