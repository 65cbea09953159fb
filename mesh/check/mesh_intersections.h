// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mesh/model/mesh.h"

namespace openfab::scene {

struct Intersections {
    int64_t pairs = 0;   ///< of triangles that cross
    bool all = true;     ///< false: the search was ended, there may be more
    int32_t first = -1;  ///< lowest triangle that crosses another, and the lowest it crosses
    int32_t second = -1;
    Vec3d place;  ///< where an edge of one goes through the other, nearly
};

/// Pairs of triangles that cross each other. An edge of one must go from one side of the other's
/// plane to the other side beyond all rounding, so that what only touches (parts side by side,
/// triangles in one plane) is not counted. Ends after 20 M pairs looked at closely, or 100,000
/// found: no mesh makes it take more than seconds.
Intersections find_intersections(const Mesh& mesh);

}  // namespace openfab::scene
