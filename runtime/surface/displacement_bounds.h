// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds of where a displaced surface may lie, without dicing it (Surface::displacement_bounds).

#include <vector>

#include "runtime/surface/base_mesh.h"
#include "runtime/surface/patch_table.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

/// Appends the pieces of Surface::displacement_bounds of a patch.
void add_displacement_bounds(const BaseMesh& base, const PatchTable& table, int32_t patch,
                             std::vector<GrownPolygon>* out);

/// Returns a box of the displacements on a tile of a displaced triangle.
Box3d tile_displacements(const BaseMesh& base, const PatchTable& table, int32_t patch);

}  // namespace openfab::surface
