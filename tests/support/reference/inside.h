// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A plain point-in-solid test: the exact winding number of a voxel's center, perturbed by (e, e²,
// e³), counted along +x over every triangle. Vertices snap to floor(256 v + 0.5) in voxel units;
// all tests are exact in 128 bits.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::reference {

using SnappedTriangle = std::array<Vec3<int64_t>, 3>;

/// Snaps a point in part-local mm to 1/256 voxel. `local_to_voxel` is from part::local_to_voxel.
Vec3<int64_t> snap(const Affine3d& local_to_voxel, const Vec3d& point);

/// Snaps triangles, and flips them if the map mirrors, so that they stay counter-clockwise from
/// outside.
std::vector<SnappedTriangle> snap_triangles(const Affine3d& local_to_voxel,
                                            const std::vector<std::array<Vec3d, 3>>& triangles);
std::vector<SnappedTriangle> snap_triangles(const Affine3d& local_to_voxel,
                                            const std::vector<std::array<Vec3f, 3>>& triangles);

/// Returns the winding number of voxel (i, j, k).
int32_t winding(const std::vector<SnappedTriangle>& triangles, const Vec3i& voxel);

/// Returns 1 where the winding number is above zero:
/// for voxels [0, size): [(z * size.y + y) * size.x + x].
std::vector<uint8_t> inside(const std::vector<SnappedTriangle>& triangles, const Vec3i& size);

}  // namespace openfab::reference
