// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// The stage that tells which voxels look at the surface point nearest to their centre: one bool
/// output, OPENFAB_ARG_DEMAND. Where it is false, inputs DISTANCE, NEAREST and NEAREST_GRAD may
/// have any value: no output, loop, query or print of `volume` changes by a bit. Errs towards true,
/// and is computed from uniforms, the frame and the voxel's place alone. No outputs where every
/// voxel looks, or none has anything to look at. `volume` has its footprints.
ir::Stage form_demand(const ir::Stage& volume);

}  // namespace openfab::passes
