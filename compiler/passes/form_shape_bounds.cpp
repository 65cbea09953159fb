// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_shape_bounds.h"

#include "compiler/ir/looks.h"
#include "compiler/ir/shape_distance.h"
#include "compiler/passes/form_looks.h"
#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

std::optional<std::array<int32_t, 2>> ends_in_shape(int32_t kind) {
    if (kind == OPENFAB_ARG_SHAPE_POINT)
        return {{OPENFAB_ARG_SHAPE_POINT_LO, OPENFAB_ARG_SHAPE_POINT_HI}};
    if (kind == abi::kShapeDistance) return {{abi::kShapeDistanceLo, abi::kShapeDistanceHi}};
    return std::nullopt;
}

bool is_unknown_in_shape(int32_t /*kind*/) {
    return false;
}

}  // namespace

ir::Stage form_shape_bounds(const ir::Stage& shape) {
    ir::Stage out;
    out.kind = ir::StageKind::kShapeBounds;
    IntervalForm form(shape, &out, ends_in_shape, is_unknown_in_shape);
    const std::vector<Interval>& values = form.run();
    for (const ir::Output& output : shape.outputs) {
        const Interval& value = values[output.value];
        out.outputs.push_back(
            {output.name + "_lo", OPENFAB_ARG_SHAPE_VALUE_LO, output.a, output.b, value.lo});
        out.outputs.push_back(
            {output.name + "_hi", OPENFAB_ARG_SHAPE_VALUE_HI, output.a, output.b, value.hi});
    }
    if (const std::optional<ir::ValueId> looks = form_shape_looks(shape, values, &form.builder())) {
        ir::Builder& b = form.builder();
        const ir::ValueId value = b.select(*looks, b.constant(1.0f), b.constant(0.0f));
        out.outputs.push_back({"looks", OPENFAB_ARG_SHAPE_VALUE_HI, ir::kLooksSlot, 0, value});
    }
    return out;
}

}  // namespace openfab::passes
