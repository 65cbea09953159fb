// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tops of the columns that a mesh covers, for the depth map of support.

#include "runtime/part/part.h"
#include "runtime/solid/tops.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/patch_index.h"

namespace openfab::solid {

/// The surface of a part in the grid of a print.
struct GridSurface {
    const part::Part& part;
    const surface::Surface& surface;
    const voxel::PatchIndex& patches;  ///< of the surface
    const part::Grid& grid;
};

/// Raises tops to the highest voxel that a part with an identity surface covers in each column.
void raise_to_covered(const GridSurface& on, const Columns& columns, TopRows* rows);

/// Raises tops to the highest voxel whose center is within the displacement bounds of a part's
/// patches.
void raise_to_bounds(const GridSurface& on, const Columns& columns, TopRows* rows);

}  // namespace openfab::solid
