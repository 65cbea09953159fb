// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Checks that a mesh can be printed: closed, consistently oriented, with a volume.

#include "base/result.h"
#include "mesh/check/mesh_edges.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Counts how often edges are used.
EdgeCounts count_edges(const Mesh& mesh);
/// Same, with the mesh's sorted_edges.
EdgeCounts count_edges(const Mesh& mesh, const std::vector<Edge>& edges);

/// Joins the equal corners of a mesh that has three for each triangle, as files of STL do, so that what is done next takes a
/// sixth of the vertices; leaves others, those of several parts, and those for which memory is short, as they are.
/// prepare_mesh makes the same of both.
void join_corners(MeshSource* source, int64_t memory_bytes);

/// Prepares a mesh, now in millimetres, for printing, or reports why it cannot be printed, with
/// counts and one location: vertices of equal positions and of the same part are welded if the mesh
/// is open as it stands; triangles with two equal corners are dropped with a warning, and so are
/// duplicates where the mesh is not closed with them; open, non-manifold and inconsistently
/// oriented meshes and those without volume are refused; shells are oriented by orient_shells; a
/// size under 1 mm or over 1 m is a warning, over 100 m or not finite an error. Vertices that no
/// triangle uses are dropped. Afterwards the source's groups and parts no longer fit its mesh; its
/// lines do. With `repair` meshes that are not closed become so (mesh_repair.h), with a warning
/// that says what was done.
Result<void> prepare_mesh(MeshSource* source, bool repair = false);

}  // namespace openfab::mesh
