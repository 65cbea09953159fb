// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns the stage that computes which voxels need the surface point nearest to their centre: one
/// bool output, OPENFAB_ARG_DEMAND. If it is false, inputs DISTANCE, NEAREST and NEAREST_GRAD may
/// have any value: no output, loop, query or printf of `volume` changes by a bit. Errs towards
/// true; computed from uniforms, the frame and the voxel's position alone. Without outputs if every
/// voxel needs the point, or none does. Run attach_footprints on `volume` first.
ir::Stage form_demand(const ir::Stage& volume);

}  // namespace openfab::passes
