// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/expand_picks.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "compiler/passes/hoist_uniforms.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::Op;
using ir::Type;
using ir::ValueId;

/// first + step * element, in wrapping arithmetic.
struct Series {
    uint32_t first = 0;
    uint32_t step = 0;
};

std::optional<Series> series_of(const ir::Stage& stage, const Instr& pick) {
    if (pick.type != Type::kInt && pick.type != Type::kUint) return std::nullopt;
    const size_t count = pick.args.size() - 1;
    const auto element = [&](size_t k) -> const Instr& { return stage.instrs[pick.args[1 + k]]; };
    const auto bits = [&](size_t k) { return element(k).bits; };
    const Series out{bits(0), count > 1 ? bits(1) - bits(0) : 0};
    for (size_t k = 0; k < count; ++k) {
        const uint32_t expected = out.first + out.step * static_cast<uint32_t>(k);
        if (element(k).op != Op::kConst || bits(k) != expected) return std::nullopt;
    }
    return out;
}

ValueId compute_series(const Instr& pick, const Series& series, ir::Builder* b) {
    const ValueId index = pick.args[0];
    const Type of_index = b->type(index);
    const auto last = static_cast<uint32_t>(pick.args.size() - 2);
    ValueId at = b->binary(Op::kMin, index, b->constant(of_index, last));
    if (of_index == Type::kInt) at = b->binary(Op::kMax, at, b->constant(0));
    at = b->convert(at, pick.type);
    if (series.step != 1) at = b->binary(Op::kMul, at, b->constant(pick.type, series.step));
    if (series.first != 0) at = b->binary(Op::kAdd, at, b->constant(pick.type, series.first));
    return at;
}

}  // namespace

ValueId choose_element(const Instr& pick, ir::Builder* b) {
    const ValueId index = pick.args[0];
    const Type type = b->type(index);
    const auto count = static_cast<uint32_t>(pick.args.size() - 1);
    ValueId out = pick.args.back();
    for (uint32_t k = count - 1; k-- > 0;) {
        const Op here = k == 0 ? Op::kLe : Op::kEq;
        out = b->select(b->binary(here, index, b->constant(type, k)), pick.args[1 + k], out);
    }
    return out;
}

void expand_picks(ir::Stage* stage) {
    const bool any = std::any_of(stage->instrs.begin(), stage->instrs.end(),
                                 [](const Instr& instr) { return instr.op == Op::kPick; });
    if (!any) return;
    const ir::Stage old = std::exchange(*stage, {});
    stage->kind = old.kind;
    stage->printfs = old.printfs;
    const std::vector<bool> uniform = uniform_values(old);
    ir::Builder builder(stage);
    std::vector<ValueId> renamed;
    renamed.reserve(old.instrs.size());
    for (const Instr& instr : old.instrs) {
        Instr copy = instr;
        for (ValueId& arg : copy.args)
            arg = renamed[arg];
        builder.set_span(instr.span);
        if (instr.op == Op::kPick) {
            const bool table = std::all_of(instr.args.begin() + 1, instr.args.end(),
                                           [&](ValueId arg) { return uniform[arg]; });
            if (const std::optional<Series> series = series_of(old, instr)) {
                renamed.push_back(compute_series(copy, *series, &builder));
                continue;
            }
            if (!table) {
                renamed.push_back(choose_element(copy, &builder));
                continue;
            }
        }
        renamed.push_back(builder.append(std::move(copy)));
    }
    for (ir::Output output : old.outputs) {
        output.value = renamed[output.value];
        stage->outputs.push_back(std::move(output));
    }
}

}  // namespace openfab::passes
