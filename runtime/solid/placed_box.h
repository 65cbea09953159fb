// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "runtime/solid/solid.h"

namespace openfab::solid {

/// Returns the voxels of the grid that what lies in a box of part-local mm may cover, with one to spare;
/// empty, at 0, where that is beside the grid.
Box3i voxels_of(const Place& where, const Box3f& box);

}  // namespace openfab::solid
