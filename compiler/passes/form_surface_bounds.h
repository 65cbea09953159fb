// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// The interval form of a surface stage over a patch (compiler/passes/interval.h): outputs
/// DISPLACEMENT_LO and HI of each axis and SURFACE_OUT_LO and HI. The displacement is what the
/// stage returns, before bound_displacement cuts it (surface/bounds_batch.h knows of that); where
/// nothing is known of it the ends are NaN. `surface` has its footprints.
ir::Stage form_surface_bounds(const ir::Stage& surface);

}  // namespace openfab::passes
