// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/outputs.h"

#include <fmt/format.h>

#include <utility>

namespace openfab::translate {

using ir::ValueId;

namespace {

std::string component_name(const std::string& name, int32_t components, int32_t i) {
    return components == 1 ? name : fmt::format("{}.{}", name, "xyzw"[i]);
}

}  // namespace

void Outputs::add(std::string name, int32_t kind, int32_t a, int32_t b, ValueId value) {
    stage_->outputs.push_back({std::move(name), kind, a, b, value});
}

void Outputs::surface(const check::Stage& stage) {
    const Value& displacement = paths_.variables[paths_.frame.result].value;
    for (int32_t axis = 0; axis < 3; ++axis) {
        add(component_name("displacement", 3, axis), OPENFAB_ARG_POSITION, 0, axis,
            displacement[axis]);
    }
    varyings(stage, check::SymbolKind::kSurfaceOutput, OPENFAB_ARG_SURFACE_OUT);
}

void Outputs::varyings(const check::Stage& stage, check::SymbolKind which, int32_t kind) {
    for (const auto& symbol : stage.symbols) {
        if (symbol->kind != which) continue;
        const Variable& v = paths_.variables[paths_.variable_of(*symbol)];
        calls_.check_assigned(v, *symbol);
        for (int32_t i = 0; i < symbol->type.size; ++i) {
            add(component_name(symbol->name, symbol->type.size, i), kind, symbol->index, i,
                v.value[i]);
        }
    }
}

void Outputs::shape(const check::Stage& stage) {
    add("value", OPENFAB_ARG_SHAPE_VALUE, 0, 0, paths_.variables[paths_.frame.result].value[0]);
    varyings(stage, check::SymbolKind::kShapeOutput, OPENFAB_ARG_SHAPE_OUT);
}

void Outputs::grow() {
    const Value& node = paths_.variables[paths_.frame.result].value;
    const std::vector<ir::Varying>& members = place_.fablet.ir.shape_outputs;
    size_t at = 0;
    for (size_t m = 0; m < members.size(); ++m) {
        for (int32_t i = 0; i < members[m].components; ++i)
            add(fmt::format("{}.{}", members[m].name, i), OPENFAB_ARG_SHAPE_OUT,
                static_cast<int32_t>(m), i, node[at++]);
    }
}

void Outputs::dither(const check::Stage& stage) {
    add("choice", OPENFAB_ARG_CHOICE, 0, 0, paths_.variables[paths_.frame.result].value[0]);
    for (const ir::Instr& instr : stage_->instrs) {
        if (instr.op != ir::Op::kLoop) continue;
        sink_->report(instr.span, diag::kTooComplex, "a loop of a dither rule that is not unrolled")
            .note(stage.span, "stage declared `@Dither` here")
            .help(fmt::format("a loop over the fractions, `for (int i = 0; i < attr.count; ++i)`, "
                              "is unrolled: here they are {}",
                              place_.fablet.ir.slot_count + 1));
        return;
    }
}

void Outputs::volume() {
    const Value& amounts = paths_.variables[paths_.frame.result].value;
    for (const ir::Uniform& u : place_.fablet.ir.uniforms) {
        if (u.kind != OPENFAB_UNIFORM_MATERIAL) continue;
        for (int32_t i = 0; i < u.array_length; ++i) {
            const int32_t slot = u.first_index + i;
            add(u.array_length == 1 ? u.name : fmt::format("{}[{}]", u.name, i), OPENFAB_ARG_WEIGHT,
                slot, 0, amounts[slot]);
        }
    }
    const int32_t slot = place_.fablet.ir.void_slot;
    if (slot >= 0) add("VOID", OPENFAB_ARG_WEIGHT, slot, 0, amounts[slot]);
}

}  // namespace openfab::translate
