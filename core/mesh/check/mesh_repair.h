// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Closes open meshes at load, for `"repair": "winding"`.
//
// The generalised winding number of an open mesh at a point is the winding number of the mesh with
// caps over its holes, an integer, less the solid angle of the caps alone. Over a flat hole both
// classify the same voxels as inside; over others, the caps define the surface, near that of the
// generalised number. So the caps are added to the mesh once, and later stages (coverage by
// integers, distances, displacement) work on a closed surface: prints are as fast as with closed
// meshes, and nothing leaks through a hole.

#include <cstdint>
#include <vector>

#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Returns for each vertex the lowest one it is welded to: vertices at open edges are welded within
/// a hundred-thousandth of the mesh's diagonal, for seams of parts that were exported separately.
std::vector<int32_t> weld_open_edges(const Mesh& mesh);

/// Statistics of close_mesh.
struct MeshRepair {
    int64_t turned = 0;    ///< triangles that were flipped
    int64_t holes = 0;     ///< holes that were capped
    int64_t caps = 0;      ///< triangles of the caps
    double widest_mm = 0;  ///< diagonal of the box of the widest hole
    Vec3d center;          ///< of that box
};

/// Flips triangles to agree with their neighbours, caps each loop of open edges with a cone of
/// triangles from its center, and gives sheets that touch along an edge separate vertices.
/// Afterwards each edge of the mesh has two triangles in opposite directions.
/// Caps take attributes from the rim, normals (`n`) are their own; they have the lines of the rim's
/// triangles.
MeshRepair close_mesh(MeshSource* source);

}  // namespace openfab::mesh
