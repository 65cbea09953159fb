// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// When a part gives way sideways under its loads though nothing in it breaks.

#include <climits>

#include "mechanics/part/stresses.h"

namespace openfab::mechanics {

/// Of the shape that is found; the factor is as near as its square, over the gap to the next.
constexpr double kBucklingTolerance = 0.02;

struct Buckling {
    double factor = 0;    ///< of all loads, at which it buckles; 0: at none
    double at_least = 0;  ///< where it was not computed, for it is far: about what it is above
    double excess = 1;    ///< how many times too high the factor may be (across.h)
    Vec3 moves_at_mm{}, moves{};  ///< where it moves most, and a unit vector there
    double residual = 0;
    int iterations = 0;
    bool converged = true, stopped = false;
    bool given_up = false;  ///< it took more work than was allowed
};

/// About the least factor that a part can have that is so slender and so compressed: that of struts as thick as
/// the part is at each place, as long as the part, clamped at one end. 1e6 at most.
/// `dithered`: by means over blocks, for single voxels are pressed in what is pulled, too;
/// else `where` is set to the element.
double least_buckling_factor(const PartProblem& problem, const PartFields& fields,
                             Field<double, kElastic>* moved_mm, bool dithered,
                             size_t* where = nullptr);

/// The least factor by which all loads, and what is moved, may be multiplied before the part buckles: the linear
/// eigenvalue problem of its stiffness and of its stresses, for the most compressed shape (LOBPCG, Knyazev 2001).
/// Factors above `far` are told as `at_least`. Gives up after `most_work` iterations of solutions. Takes the stiffness
/// out of `problem` for its time.
Buckling buckling_of(PartProblem* problem, Field<double, kElastic>* moved_mm, double far,
                     const SolveOptions& options, int most_work = INT_MAX);

/// Memory of all of it.
int64_t buckling_bytes(const Grid& grid);

}  // namespace openfab::mechanics
