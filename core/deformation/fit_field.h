// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "deformation/field.h"

namespace openfab::deformation {

/// Where something should be, and where it was found.
struct Pair {
    Vec3d nominal_mm, measured_mm;
};

/// Sets the displacements of a field of given nodes to those of least squares over the pairs, with second
/// differences as small as that allows: what is linear stays so, also beyond the pairs. `smoothness`: the weight
/// of these against a pair in each cell. Returns the root of the mean square of what is left, in mm.
double fit_field(const std::vector<Pair>& pairs, double smoothness, Field* field);

}  // namespace openfab::deformation
