// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/stage_inputs.h"

#include "abi/grow_table.h"

namespace openfab::translate {

using ir::Op;
using ir::ValueId;

Value StageInputs::frame_vector(int32_t first) {
    Value out;
    for (int32_t i = 0; i < 3; ++i) {
        out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_FRAME, first + i, 0));
    }
    return out;
}

/// In the order of operations of abi/fablet_table.h.
Value StageInputs::voxel_center() {
    const Value center = frame_vector(OPENFAB_FRAME_CENTER);
    const Value origin = frame_vector(OPENFAB_FRAME_ORIGIN);
    const Value step_i = frame_vector(OPENFAB_FRAME_STEP_I);
    const Value step_j = frame_vector(OPENFAB_FRAME_STEP_J);
    const Value step_k = frame_vector(OPENFAB_FRAME_STEP_K);
    Value at;
    for (int32_t axis = 0; axis < 3; ++axis) {
        at.push_back(emit_.input(ir::Type::kFloat, ir::kVoxelCoord, axis, 0));
    }
    Value out;
    for (size_t c = 0; c < 3; ++c) {
        ValueId sum = emit_.binary(Op::kAdd, emit_.binary(Op::kMul, at[0], step_i[c]),
                                   emit_.binary(Op::kMul, at[1], step_j[c]));
        sum = emit_.binary(Op::kAdd, sum, emit_.binary(Op::kMul, at[2], step_k[c]));
        sum = emit_.binary(Op::kAdd, sum, origin[c]);
        out.push_back(emit_.binary(Op::kAdd, sum, center[c]));
    }
    return out;
}

Value StageInputs::shape_point() {
    Value point;
    for (int32_t axis = 0; axis < 3; ++axis)
        point.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_SHAPE_POINT, axis, 0));
    return formulas_.binary(Op::kAdd, point, frame_vector(OPENFAB_FRAME_CENTER));
}

Value StageInputs::attribute(const check::Expr& expr) {
    const auto surface = [&](openfab_surface_attr which, int32_t components) {
        Value out;
        for (int32_t i = 0; i < components; ++i) {
            out.push_back(emit_.input(ir::Type::kFloat, OPENFAB_ARG_SURFACE_ATTR, which, i));
        }
        return out;
    };
    switch (expr.attribute) {
        case check::Attribute::kP:
            if (place_.kind == ir::StageKind::kShape) return shape_point();
            return formulas_.binary(Op::kAdd, surface(OPENFAB_SURFACE_P, 3),
                                    frame_vector(OPENFAB_FRAME_CENTER));
        case check::Attribute::kN:
            return surface(OPENFAB_SURFACE_N, 3);
        case check::Attribute::kNg:
            return surface(OPENFAB_SURFACE_NG, 3);
        case check::Attribute::kUv:
            return surface(OPENFAB_SURFACE_UV, 2);
        case check::Attribute::kDpdu:
            return surface(OPENFAB_SURFACE_DPDU, 3);
        case check::Attribute::kDpdv:
            return surface(OPENFAB_SURFACE_DPDV, 3);
        case check::Attribute::kInstance:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_INSTANCE, 0, 0)};
        case check::Attribute::kVoxelCenter:
            return voxel_center();
        case check::Attribute::kVoxelSize:
            return frame_vector(OPENFAB_FRAME_VOXEL_SIZE);
        case check::Attribute::kBuildPosition: {
            Value at;
            for (int32_t axis = 0; axis < 3; ++axis) {
                at.push_back(emit_.input(ir::Type::kFloat, ir::kVoxelCoord, axis, 0));
            }
            return formulas_.binary(
                Op::kAdd, frame_vector(OPENFAB_FRAME_BUILD_ORIGIN),
                formulas_.binary(Op::kMul, at, frame_vector(OPENFAB_FRAME_VOXEL_SIZE)));
        }
        case check::Attribute::kVoxel: {
            Value index;
            for (int32_t axis = 0; axis < 3; ++axis)
                index.push_back(emit_.input(ir::Type::kInt, ir::kVoxelIndex, axis, 0));
            return index;
        }
        case check::Attribute::kSeed:
            return {emit_.input(ir::Type::kUint, OPENFAB_ARG_GRID, OPENFAB_GRID_SEED, 0)};
        case check::Attribute::kCount:
            return {emit_.constant(place_.fablet.ir.slot_count + 1)};
        case check::Attribute::kChild:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_CHILD, 0)};
        case check::Attribute::kLevel:
            return {emit_.input(ir::Type::kInt, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_LEVEL, 0)};
        case check::Attribute::kPath:
            return {emit_.input(ir::Type::kUint, OPENFAB_ARG_GROW_PLACE, OPENFAB_GROW_PATH, 0)};
    }
    return {};
}

}  // namespace openfab::translate
