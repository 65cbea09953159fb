// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The worst loads of a part whose loads are not known: where a push of one newton strains a weak place most.

#include "mechanics/stand/modes.h"

namespace openfab::mechanics {

/// A push into a face of the surface, far from the place that it strains.
struct Push {
    Vec3 at_mm{}, along{};   ///< where, and the unit vector of the force
    double MPa_of_N = 0;     ///< von Mises stress at the place for each newton, or a little more
    double breaks_at_N = 0;  ///< 0: the material's strength is not known
    bool stopped = false;    ///< by the options' progress
    bool converged = true;
};

/// Where a mode strains the part most. One solution says it of all pushes at once: that of the adjoint load,
/// whose work on a displacement is the stress there, taken in the direction in which the mode strains it.
/// What is pushed right beside the place is left out: it would be a dent.
Push worst_push(PartProblem* problem, const Mode& mode, const SolveOptions& options);

}  // namespace openfab::mechanics
