// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/result.h"
#include "mesh/check/mesh_edges.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Orients the shells of a closed mesh by their nesting. Outermost shells of negative volume are
/// flipped with a warning; if all of them are, so is the whole mesh, so that cavities stay
/// cavities. Warns of a shell inside another that is not a cavity: it cuts nothing out. `edges`:
/// sorted_edges of the mesh; only which triangles share an edge is read from them. Fails where so
/// many shells overlap along x that this takes too long.
Result<void> orient_shells(MeshSource* source, const std::vector<Edge>& edges);

}  // namespace openfab::mesh
