// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// The interval form of a surface stage over a patch (compiler/passes/interval.h): outputs
/// DISPLACEMENT_LO and HI of each axis and SURFACE_OUT_LO and HI. The displacement is the one after
/// bound_displacement, which makes what is not finite 0 and cuts to the user's bound B: where
/// nothing is known of it and B is infinite the ends are NaN. `surface` has its footprints and its
/// outputs are still the returned vector.
ir::Stage form_surface_bounds(const ir::Stage& surface);

}  // namespace openfab::passes
