// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Holes and gaps: a plane cuts a hole in an area that a circle holds, and a gap in no such area.

#include <functional>

#include "base/vec.h"

namespace openfab::inspection {

/// Whether some plane through a voxel cuts what is open around it in an area of less than that diameter. `open` also answers
/// for voxels outside of the box.
bool is_hole(const std::function<bool(const Vec3i&)>& open, const Vec3d& pitch_mm,
             const Vec3i& voxel, double diameter_mm);

}  // namespace openfab::inspection
