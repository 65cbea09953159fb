// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns the interval form of a volume stage over a block of voxels (compiler/passes/interval.h):
/// outputs WEIGHT_LO and WEIGHT_HI of each slot. Ends with equal bits mean that every voxel of the
/// block has that amount (0 and -0 count as equal); NaN means unknown. Run attach_footprints on
/// `volume` first.
ir::Stage form_volume_bounds(const ir::Stage& volume);

}  // namespace openfab::passes
