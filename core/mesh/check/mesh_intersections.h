// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// The pairs of triangles that cross.
struct Intersections {
    int64_t pairs = 0;   ///< number of pairs
    bool all = true;     ///< false: the search was stopped, there may be more
    int32_t first = -1;  ///< lowest triangle that crosses another, and the lowest it crosses
    int32_t second = -1;
    Vec3d point;  ///< approximately where an edge of one passes through the other
};

/// Finds the pairs of triangles that cross each other. An edge of one must pass through the other's
/// plane by more than all rounding, so that triangles that only touch (parts side by side, coplanar
/// triangles) do not count. Stops after 20 M pairs tested, or 100,000 found, which bounds the time
/// to seconds.
Intersections find_intersections(const Mesh& mesh);

}  // namespace openfab::mesh
