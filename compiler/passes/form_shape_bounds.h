// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Returns the interval form of a shape's value over a box of points (compiler/passes/interval.h): outputs
/// SHAPE_VALUE_LO and HI, both NaN where the value is not known, or may be a NaN. Run attach_footprints on
/// `shape` first.
///
/// A shape that reads distances to objects has one output more, of form_shape_looks (abi/looks.h).
ir::Stage form_shape_bounds(const ir::Stage& shape);

}  // namespace openfab::passes
