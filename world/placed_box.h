// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/vec.h"
#include "world/world.h"

namespace openfab::world {

/// Returns the box of an object, or of a piece of it (-1: all of it), under an affine map, before any
/// displacement: exact for meshes and for whole beams. Of a shape and of what grows it is that of the box
/// which stands for it.
Box3d placed_box(const World& world, const Object& object, int32_t piece, const Affine3d& map);

/// Returns whether only the solid itself knows the box of a placement: as whose mesh a box stands, and of pieces
/// of beams.
bool asks_solid(const World& world, const Placement& placement);
/// How many points are looked at for that.
size_t points_of(const World& world, const Object& object);

}  // namespace openfab::world
