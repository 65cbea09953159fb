// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arguments of the kernels of a shape (openfab_shape in abi/fablet_table.h) that are distances to
// objects, the Object uniforms of its fablet, each in its own place: the runtime computes them for the
// points, or the boxes, of a call. At other points the segments of a shape may query them.

#include "abi/fablet_table.h"

namespace openfab::abi {

/// The signed distance, mm, to object `a` at the point (SHAPE_POINT).
constexpr auto kShapeDistance = static_cast<openfab_arg_kind>(60);
/// Bounds of it over the box (SHAPE_POINT_LO, HI); NaN, both, where it is not known.
constexpr auto kShapeDistanceLo = static_cast<openfab_arg_kind>(61);
constexpr auto kShapeDistanceHi = static_cast<openfab_arg_kind>(62);

}  // namespace openfab::abi
