// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "base/vec.h"

namespace openfab::tools {

/// Returns how far a turned grid goes on beyond its outermost centres, in steps along one of its axes, before `outside`
/// begins: half a texel, and from there as far as a cubic texel of the result reaches, of which a look-up within the
/// grid takes a share. `step` is that axis, in mm; it is at right angles to the others.
inline double border_reach(const Vec3d& step, double pitch_mm) {
    const double texels = (std::abs(step.x) + std::abs(step.y) + std::abs(step.z)) /
                          (step.x * step.x + step.y * step.y + step.z * step.z);
    return 0.5 + pitch_mm * texels;
}

}  // namespace openfab::tools
