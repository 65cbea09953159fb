// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns the interval form of a surface stage over a patch (compiler/passes/interval.h): outputs
/// DISPLACEMENT_LO and HI of each axis and SURFACE_OUT_LO and HI. The displacement is the one that
/// the stage returns, before bound_displacement limits it (surface/bounds_batch.h allows for that);
/// its ends are NaN if unknown. Run attach_footprints on `surface` first.
ir::Stage form_surface_bounds(const ir::Stage& surface);

}  // namespace openfab::passes
