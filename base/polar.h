// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The polar split of a transform: what turns a part apart from what stretches it.

#include <array>

#include "base/result.h"

namespace openfab::scene {

/// M = R S, row-major 3 x 3. R is orthogonal and has the sign of det M (so it may reflect); S is
/// symmetric and positive definite. Entries of S are rounded to 1e-12, and an S within 1e-9 of a
/// diagonal (or of the identity) is made so, which lets placements that differ in rotation alone
/// share a mesh.
struct PolarFactors {
    std::array<double, 9> r;
    std::array<double, 9> s;
};

/// Fails where M is not finite or (nearly) singular: |det M| < 1e-12, or less than 1e-9 of its
/// largest entry cubed.
Result<PolarFactors> polar_factors(const std::array<double, 9>& m);

/// Cofactors over the determinant, row-major 3 x 3; takes normals through M.
std::array<double, 9> inverse_transposed(const std::array<double, 9>& m);

}  // namespace openfab::scene
