// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns the interval form of a volume stage over a block of voxels (compiler/passes/interval.h):
/// outputs WEIGHT_LO and WEIGHT_HI of each slot. Ends with equal bits mean that every voxel of the
/// block has that amount (0 and -0 count as equal); NaN means unknown. Run attach_footprints on
/// `volume` first.
///
/// A volume stage that reads the distance has one output more, of form_looks (abi/looks.h).
ir::Stage form_volume_bounds(const ir::Stage& volume);

/// Drops that output, or that of a shape's bounds; returns whether there was one.
bool drop_looks(ir::Stage* bounds);
/// Returns whether that output is there and follows from the bounds of the distance, or of one to an object.
bool says_looks(const ir::Stage& bounds);

}  // namespace openfab::passes
