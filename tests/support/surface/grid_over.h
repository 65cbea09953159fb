// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "runtime/part/part.h"

namespace openfab::testing {

/// A grid of about 30 voxels over a box, mm. With `on_centers` whole and half millimetres are on
/// voxel centers and voxels are cubes, else `stretch` times as long as a cube's.
inline part::Grid grid_over(const Box3d& box, bool on_centers, const Vec3d& stretch) {
    part::Grid grid;
    const double extent = std::max({box.size().x, box.size().y, box.size().z});
    const double shift = on_centers ? 0.5 : 0.31;
    for (int axis = 0; axis < 3; ++axis) {
        const double pitch = on_centers ? 0.125 : extent / 27 * stretch[axis];
        grid.pitch_mm[axis] = pitch;
        grid.origin_mm[axis] = (std::floor(box.lo[axis] / pitch) - shift) * pitch;
        grid.size[axis] =
            static_cast<int32_t>(std::ceil((box.hi[axis] - grid.origin_mm[axis]) / pitch)) + 1;
    }
    return grid;
}

}  // namespace openfab::testing
