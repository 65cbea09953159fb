// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts a shape to a closed triangle mesh.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/figures/shape.h"

namespace openfab::figures {

struct TriangleMesh {
    std::vector<Vec3d> points;
    std::vector<Vec3d> normals;                     ///< unit, one per point
    std::vector<std::array<int32_t, 3>> triangles;  ///< counter-clockwise from outside
    Box3d box;
};

/// Polygonises by marching tetrahedra over cubes of `cell_mm` cut into six tetrahedra each
/// (Kuhn's): closed, consistently oriented, without ambiguous cases. Slivers are smoothed away:
/// points slide along the surface towards the mean of their neighbours and return to it by Newton
/// steps. `box` must contain the shape with a margin of a cell.
TriangleMesh polygonise(const Shape& shape, const Box3d& box, double cell_mm);

/// Returns OBJ text with normals and with the side view as texture coordinates: u runs along x from
/// the lowest to the highest, v along z; both flanks of an animal carry the same picture and there
/// is no seam. `name` and the cell go into its first lines.
std::string write_obj(const TriangleMesh& mesh, const std::string& name, double cell_mm);

}  // namespace openfab::figures
