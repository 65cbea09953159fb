// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The output of volume_bounds that belongs to no slot: whether some voxel of a cube may have to know
// its nearest surface point. It is 0 where all distances between DISTANCE_LO and HI, with any
// attributes and gradients, give each voxel the amounts that its own nearest surface point gives;
// else 1, or NaN (compiler/passes/form_looks.h). A kernel whose answer does not follow from the
// distance has no such output.
//
// Likewise of a shape's bounds: whether the value at a point of the box may follow from more of the distances to objects than
// their bounds.

#include <cstdint>

#include "abi/fablet_table.h"

namespace openfab::abi {

/// An output WEIGHT_HI, or SHAPE_VALUE_HI, of this slot.
constexpr int32_t kLooksSlot = -1;

inline bool is_looks(const openfab_arg& arg) {
    return (arg.kind == OPENFAB_ARG_WEIGHT_HI || arg.kind == OPENFAB_ARG_SHAPE_VALUE_HI) &&
           arg.a == kLooksSlot;
}

}  // namespace openfab::abi
