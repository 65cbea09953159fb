// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Adds to each Sample the changes of its u and v along the stage's axes, by forward-mode
/// differentiation (dual numbers) of what they are computed from: the voxel's three axes in the
/// volume stage, the lattice's two on the surface (the third is 0). Integers, rounding, the signed
/// distance and the results of other lookups count as constant.
void attach_footprints(ir::Stage* stage);

}  // namespace openfab::passes
