// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes that are not closed, made closed at load, for `"repair": "winding"`.
//
// The generalised winding number of an open mesh at a point is the winding number of the mesh with
// caps over its holes, an integer, less the solid angle of the caps alone. Over a flat hole the two
// say the same voxels are inside; over one that is not, the caps say where the surface is, which
// the generalised number would have somewhere near. So the caps are put into the mesh, once, and
// everything behind (coverage by integers, distances, displacement) has a closed surface to work
// on: prints are as fast as of closed meshes, and nothing leaks through a hole.

#include <cstdint>
#include <vector>

#include "mesh/model/mesh_source.h"

namespace openfab::scene {

/// For each vertex the one that it is welded to, lowest first: those at open edges that lie within
/// a hundred-thousandth of the mesh's diagonal, as seams of parts do that were exported one by one.
std::vector<int32_t> weld_open_edges(const Mesh& mesh);

/// What close_mesh did.
struct MeshRepair {
    int64_t turned = 0;    ///< triangles whose neighbours run the other way
    int64_t holes = 0;     ///< closed by caps
    int64_t caps = 0;      ///< triangles of these
    double widest_mm = 0;  ///< diagonal of the box of the widest hole
    Vec3d place;           ///< its middle
};

/// Turns triangles to agree with their neighbours, caps what is open with a cone of triangles from
/// the middle of each loop of open edges, and gives sheets that touch along an edge vertices of
/// their own. Afterwards each edge of the mesh has two triangles that run along it opposite ways.
/// Caps take attributes from the rim, normals (`n`) are their own; they have the lines of the rim's
/// triangles.
MeshRepair close_mesh(MeshSource* source);

}  // namespace openfab::scene
