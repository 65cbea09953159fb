// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which kernels an argument belongs to. The only place that lists the kinds: one that is added to openfab_arg_kind
// and not here is a warning.

#include "abi/fablet_table.h"

namespace openfab::abi {

enum class ArgumentGroup {
    kPart,          ///< of any kernel: the same for all of a part
    kBlocks,        ///< of kernels that run over blocks
    kColumns,       ///< the list of groups, columns or vertices that a kernel runs over
    kNearest,       ///< of volume stages: at the nearest surface point
    kVolumeBounds,  ///< of volume_bounds, in pairs
    kSurfaceInput,  ///< of surface, a value per micro-vertex
    kSurfaceOutput,
    kSurfaceBoundsInput,  ///< of surface_bounds, a value per patch, in pairs
    kSurfaceBoundsOutput,
    kState,  ///< of kernels of segments
    kDerived,
    kDemand,
    kSlab,   ///< of slab kernels, which normalise and choose
    kShape,  ///< of kernels of a shape, a value per point or box
    kOther,  ///< in the compiler only, and of rules that grow (abi/grow_table.h)
};

constexpr ArgumentGroup group_of(openfab_arg_kind kind) {
    switch (kind) {
        case OPENFAB_ARG_UNIFORM:
        case OPENFAB_ARG_TEXTURE:
        case OPENFAB_ARG_FRAME:
        case OPENFAB_ARG_INSTANCE:
        case OPENFAB_ARG_VALUES:
            return ArgumentGroup::kPart;
        case OPENFAB_ARG_BLOCKS:
        case OPENFAB_ARG_BLOCK_SIZE:
            return ArgumentGroup::kBlocks;
        case OPENFAB_ARG_GROUPS:
            return ArgumentGroup::kColumns;
        case OPENFAB_ARG_NEAREST:
        case OPENFAB_ARG_NEAREST_GRAD:
        case OPENFAB_ARG_DISTANCE:
            return ArgumentGroup::kNearest;
        case OPENFAB_ARG_WEIGHT:
            return ArgumentGroup::kOther;
        case OPENFAB_ARG_NEAREST_LO:
        case OPENFAB_ARG_NEAREST_HI:
        case OPENFAB_ARG_DISTANCE_LO:
        case OPENFAB_ARG_DISTANCE_HI:
        case OPENFAB_ARG_WEIGHT_LO:
        case OPENFAB_ARG_WEIGHT_HI:
            return ArgumentGroup::kVolumeBounds;
        case OPENFAB_ARG_SURFACE_IN:
        case OPENFAB_ARG_SURFACE_IN_GRAD:
        case OPENFAB_ARG_SURFACE_ATTR:
        case OPENFAB_ARG_SURFACE_ATTR_GRAD:
            return ArgumentGroup::kSurfaceInput;
        case OPENFAB_ARG_POSITION:
        case OPENFAB_ARG_SURFACE_OUT:
        case OPENFAB_ARG_SURFACE_STATUS:
            return ArgumentGroup::kSurfaceOutput;
        case OPENFAB_ARG_SURFACE_IN_LO:
        case OPENFAB_ARG_SURFACE_IN_HI:
        case OPENFAB_ARG_SURFACE_IN_GRAD_LO:
        case OPENFAB_ARG_SURFACE_IN_GRAD_HI:
        case OPENFAB_ARG_SURFACE_ATTR_LO:
        case OPENFAB_ARG_SURFACE_ATTR_HI:
        case OPENFAB_ARG_SURFACE_ATTR_GRAD_LO:
        case OPENFAB_ARG_SURFACE_ATTR_GRAD_HI:
            return ArgumentGroup::kSurfaceBoundsInput;
        case OPENFAB_ARG_DISPLACEMENT_LO:
        case OPENFAB_ARG_DISPLACEMENT_HI:
        case OPENFAB_ARG_SURFACE_OUT_LO:
        case OPENFAB_ARG_SURFACE_OUT_HI:
            return ArgumentGroup::kSurfaceBoundsOutput;
        case OPENFAB_ARG_STATE:
        case OPENFAB_ARG_STATE_OUT:
            return ArgumentGroup::kState;
        case OPENFAB_ARG_DERIVED:
            return ArgumentGroup::kDerived;
        case OPENFAB_ARG_DEMAND:
            return ArgumentGroup::kDemand;
        case OPENFAB_ARG_CHANNELS:
        case OPENFAB_ARG_CODE:
        case OPENFAB_ARG_UNUSABLE:
        case OPENFAB_ARG_FRACTION:
        case OPENFAB_ARG_NEAREST_SOURCE:
        case OPENFAB_ARG_GRID:
        case OPENFAB_ARG_CHOICE:
        case OPENFAB_ARG_BLUE_NOISE:
            return ArgumentGroup::kSlab;
        case OPENFAB_ARG_SHAPE_POINT:
        case OPENFAB_ARG_SHAPE_POINT_LO:
        case OPENFAB_ARG_SHAPE_POINT_HI:
        case OPENFAB_ARG_SHAPE_VALUE:
        case OPENFAB_ARG_SHAPE_VALUE_LO:
        case OPENFAB_ARG_SHAPE_VALUE_HI:
        case OPENFAB_ARG_SHAPE_OUT:
            return ArgumentGroup::kShape;
    }
    return ArgumentGroup::kOther;
}

}  // namespace openfab::abi
