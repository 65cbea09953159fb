// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "mesh/check/mesh_edges.h"
#include "mesh/model/mesh_source.h"

namespace openfab::scene {

/// Looks at the shells of a closed mesh and which lie inside others. Outermost shells of negative
/// volume are flipped with a warning; if all of them are, the whole mesh is, so that its cavities
/// stay cavities. A shell inside another that bounds no hollow is a warning: nothing is cut out by
/// it. `edges`: sorted_edges of the mesh; only which triangles share an edge is read from them. An
/// error where so many shells lie behind each other that this takes too long.
Result<void> orient_shells(MeshSource* source, const std::vector<Edge>& edges);

}  // namespace openfab::scene
