// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a mesh must be before it can be printed: closed, of one orientation, with a volume.

#include "base/result.h"
#include "mesh/check/mesh_edges.h"
#include "mesh/model/mesh_source.h"

namespace openfab::scene {

EdgeCounts count_edges(const Mesh& mesh);
/// With the mesh's sorted_edges.
EdgeCounts count_edges(const Mesh& mesh, const std::vector<Edge>& edges);

/// Makes a mesh, now in millimetres, fit to print, or says why it is not, with counts and one
/// place: vertices of equal positions and of the same part are welded if the mesh is open as it
/// stands; triangles with two equal corners are dropped with a warning, and so are duplicates where
/// the mesh is not closed with them; open, non-manifold and inconsistently oriented meshes and
/// those without volume are refused; shells are turned and named as orient_shells says; a size
/// under 1 mm or over 1 m is a warning, over 100 m or not finite an error. Vertices that no
/// triangle uses are dropped. Afterwards the source's groups and parts no longer fit its mesh; its
/// lines do. With `repair` meshes that are not closed become so (mesh_repair.h), with a warning
/// that says what was done.
Result<void> prepare_mesh(MeshSource* source, bool repair = false);

}  // namespace openfab::scene
