// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_volume_bounds.h"

#include <algorithm>

#include "compiler/ir/looks.h"
#include "compiler/ir/shape_distance.h"
#include "compiler/passes/form_looks.h"
#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

std::optional<std::array<int32_t, 2>> ends_in_volume(int32_t kind) {
    switch (kind) {
        case ir::kVoxelCoord:
            return {{ir::kVoxelCoordLo, ir::kVoxelCoordHi}};
        case OPENFAB_ARG_NEAREST:
            return {{OPENFAB_ARG_NEAREST_LO, OPENFAB_ARG_NEAREST_HI}};
        case OPENFAB_ARG_DISTANCE:
            return {{OPENFAB_ARG_DISTANCE_LO, OPENFAB_ARG_DISTANCE_HI}};
        default:
            return std::nullopt;
    }
}

/// The runtime has no bound of an attribute's change along the voxel's axes, so a lookup by one
/// may filter over anything.
bool is_unknown_in_volume(int32_t kind) {
    return kind == OPENFAB_ARG_NEAREST_GRAD;
}

}  // namespace

ir::Stage form_volume_bounds(const ir::Stage& volume) {
    ir::Stage out;
    out.kind = ir::StageKind::kVolumeBounds;
    IntervalForm form(volume, &out, ends_in_volume, is_unknown_in_volume);
    const std::vector<Interval>& values = form.run();
    for (const ir::Output& output : volume.outputs) {
        const Interval& value = values[output.value];
        out.outputs.push_back(
            {output.name + "_lo", OPENFAB_ARG_WEIGHT_LO, output.a, output.b, value.lo});
        out.outputs.push_back(
            {output.name + "_hi", OPENFAB_ARG_WEIGHT_HI, output.a, output.b, value.hi});
    }
    if (const std::optional<ir::ValueId> looks = form_looks(volume, values, &form.builder())) {
        ir::Builder& b = form.builder();
        const ir::ValueId value = b.select(*looks, b.constant(1.0f), b.constant(0.0f));
        out.outputs.push_back({"looks", OPENFAB_ARG_WEIGHT_HI, ir::kLooksSlot, 0, value});
    }
    return out;
}

bool drop_looks(ir::Stage* bounds) {
    const auto looks = [](const ir::Output& o) { return o.a == ir::kLooksSlot; };
    if (std::erase_if(bounds->outputs, looks) == 0) return false;
    ir::drop_dead_values(bounds);
    return true;
}

bool says_looks(const ir::Stage& bounds) {
    ir::Stage only = bounds;
    std::erase_if(only.outputs, [](const ir::Output& o) { return o.a != ir::kLooksSlot; });
    ir::drop_dead_values(&only);
    return std::any_of(only.instrs.begin(), only.instrs.end(), [](const ir::Instr& instr) {
        return instr.op == ir::Op::kInput &&
               (instr.kind == OPENFAB_ARG_DISTANCE_LO || instr.kind == OPENFAB_ARG_DISTANCE_HI ||
                instr.kind == abi::kShapeDistanceLo || instr.kind == abi::kShapeDistanceHi);
    });
}

}  // namespace openfab::passes
