// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/hoist_uniforms.h"

#include <fmt/format.h>

#include <algorithm>

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::ValueId;

/// Lookups stay: the kernel of derived values has no textures.
bool can_move(Op op) {
    return !ir::is_effectful(op) && op != Op::kSample && op != Op::kSampleBound;
}

}  // namespace

std::vector<bool> uniform_values(const ir::Stage& stage) {
    std::vector<bool> out(stage.instrs.size());
    for (ValueId id = 0; id < stage.instrs.size(); ++id) {
        const Instr& instr = stage.instrs[id];
        out[id] = instr.op == Op::kInput
                      ? instr.kind == OPENFAB_ARG_UNIFORM
                      : can_move(instr.op) && std::all_of(instr.args.begin(), instr.args.end(),
                                                          [&](ValueId arg) { return out[arg]; });
    }
    return out;
}

namespace {

bool is_leaf(const Instr& instr) {
    return instr.op == Op::kConst || instr.op == Op::kInput;
}

}  // namespace

UniformHoister::UniformHoister(int32_t uniform_value_count)
    : uniform_value_count_(uniform_value_count) {
    derived_.kind = ir::StageKind::kDerived;
}

ValueId UniformHoister::add(Instr instr) {
    const auto id = static_cast<ValueId>(derived_.instrs.size());
    const Key key{instr.op, instr.type, instr.bits, instr.kind, instr.a, instr.b, instr.args};
    const auto [place, is_new] = known_.emplace(key, id);
    if (is_new) derived_.instrs.push_back(std::move(instr));
    return place->second;
}

int32_t UniformHoister::index_of(ValueId value) {
    const auto index = static_cast<int32_t>(derived_.outputs.size());
    const auto [place, is_new] = indices_.emplace(value, index);
    if (is_new) {
        derived_.outputs.push_back(
            {fmt::format("derived_{}", index), OPENFAB_ARG_DERIVED, index, 0, value});
    }
    return place->second;
}

void UniformHoister::hoist(ir::Stage* stage) {
    std::vector<Instr>& instrs = stage->instrs;
    const std::vector<bool> uniform = uniform_values(*stage);
    const std::vector<bool> live = ir::live_values(*stage);
    // Uniform values with other users become inputs; what they depend on moves with them.
    std::vector<bool> becomes_input(instrs.size());
    for (const ir::Output& output : stage->outputs)
        becomes_input[output.value] = true;
    for (ValueId id = 0; id < instrs.size(); ++id) {
        if (!live[id] || uniform[id]) continue;
        for (const ValueId arg : instrs[id].args)
            becomes_input[arg] = true;
    }
    std::vector<bool> moves(instrs.size());
    for (auto id = static_cast<ValueId>(instrs.size()); id-- > 0;) {
        becomes_input[id] = becomes_input[id] && uniform[id] && !is_leaf(instrs[id]);
        if (becomes_input[id]) moves[id] = true;
        if (!moves[id]) continue;
        for (const ValueId arg : instrs[id].args)
            moves[arg] = true;
    }
    std::vector<ValueId> moved(instrs.size(), kNoValue);
    for (ValueId id = 0; id < instrs.size(); ++id) {
        if (!moves[id]) continue;
        Instr copy = instrs[id];
        for (ValueId& arg : copy.args)
            arg = moved[arg];
        moved[id] = add(std::move(copy));
        if (!becomes_input[id]) continue;
        Instr input;
        input.op = Op::kInput;
        input.type = instrs[id].type;
        input.kind = OPENFAB_ARG_UNIFORM;
        input.a = uniform_value_count_ + index_of(moved[id]);
        input.span = instrs[id].span;
        instrs[id] = std::move(input);
    }
}

}  // namespace openfab::passes
