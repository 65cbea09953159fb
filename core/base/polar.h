// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Polar decomposition of a transform into a rotation and a stretch.

#include <array>

#include "base/result.h"

namespace openfab {

/// The factors of M = R S, row-major 3 x 3. R is orthogonal and has the sign of det M (so it may
/// reflect); S is symmetric and positive definite. Entries of S are rounded to 1e-12, and an S
/// within 1e-9 of a diagonal matrix (or of the identity) becomes one, so that placements that
/// differ only in rotation share a mesh.
struct PolarFactors {
    std::array<double, 9> r;
    std::array<double, 9> s;
};

/// Decomposes M. Fails where M is not finite or (nearly) singular: |det M| < 1e-12, or less than
/// 1e-9 of its largest entry cubed.
Result<PolarFactors> polar_factors(const std::array<double, 9>& m);

/// Returns the transposed inverse, row-major 3 x 3, which transforms normals.
std::array<double, 9> inverse_transposed(const std::array<double, 9>& m);

}  // namespace openfab
