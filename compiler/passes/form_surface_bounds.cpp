// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_surface_bounds.h"

#include "compiler/passes/interval.h"

namespace openfab::passes {

namespace {

using ir::Op;

std::optional<std::array<int32_t, 2>> ends_of(int32_t kind) {
    switch (kind) {
        case OPENFAB_ARG_SURFACE_IN:
            return {{OPENFAB_ARG_SURFACE_IN_LO, OPENFAB_ARG_SURFACE_IN_HI}};
        case OPENFAB_ARG_SURFACE_IN_GRAD:
            return {{OPENFAB_ARG_SURFACE_IN_GRAD_LO, OPENFAB_ARG_SURFACE_IN_GRAD_HI}};
        case OPENFAB_ARG_SURFACE_ATTR:
            return {{OPENFAB_ARG_SURFACE_ATTR_LO, OPENFAB_ARG_SURFACE_ATTR_HI}};
        case OPENFAB_ARG_SURFACE_ATTR_GRAD:
            return {{OPENFAB_ARG_SURFACE_ATTR_GRAD_LO, OPENFAB_ARG_SURFACE_ATTR_GRAD_HI}};
        default:
            return std::nullopt;
    }
}

bool is_unknown(int32_t /*kind*/) {
    return false;
}

}  // namespace

ir::Stage form_surface_bounds(const ir::Stage& surface) {
    ir::Stage out;
    out.kind = ir::StageKind::kSurfaceBounds;
    IntervalForm form(surface, &out, ends_of, is_unknown);
    const std::vector<Interval>& values = form.run();
    std::vector<ir::Output> outputs;
    for (const ir::Output& output : surface.outputs) {
        const bool moves = output.kind == OPENFAB_ARG_POSITION;
        Interval value = values[output.value];
        if (surface.instrs[output.value].type == ir::Type::kBool) {
            // Minimum and maximum of the bool.
            value.lo = form.builder().emit(Op::kNot, {value.lo});
        }
        outputs.push_back({output.name + "_lo",
                           moves ? OPENFAB_ARG_DISPLACEMENT_LO : OPENFAB_ARG_SURFACE_OUT_LO,
                           output.a, output.b, value.lo});
        outputs.push_back({output.name + "_hi",
                           moves ? OPENFAB_ARG_DISPLACEMENT_HI : OPENFAB_ARG_SURFACE_OUT_HI,
                           output.a, output.b, value.hi});
    }
    out.outputs = std::move(outputs);
    return out;
}

}  // namespace openfab::passes
