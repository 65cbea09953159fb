// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rotations in degrees. They do not use libm's sine, since placements decide bits of the output:
// these functions give the same bits on every machine, and exact values at multiples of 90 degrees.

#include "base/vec.h"

namespace openfab {

struct SinCos {
    double sin = 0;
    double cos = 1;
};

/// Returns sine and cosine with an error below 1e-15; exact at multiples of 90 degrees. `degrees`
/// is finite.
SinCos sin_cos_degrees(double degrees);

/// Returns the transform of scale (not zero), then rotation about the build's x, y, z axes in that
/// order, then translation.
Affine3d placement_transform(const Vec3d& scale, const Vec3d& rotate_deg,
                             const Vec3d& translate_mm);

}  // namespace openfab
