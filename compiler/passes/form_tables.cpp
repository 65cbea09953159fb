// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/form_tables.h"

#include <algorithm>
#include <utility>

#include "compiler/passes/expand_picks.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::Op;
using ir::ValueId;

constexpr int32_t kConstant = -1;

}  // namespace

/// Returns where the values of a table begin; equal tables are one.
int32_t TableFormer::index_of(const std::vector<std::pair<int32_t, uint32_t>>& table) {
    const auto next = first_ + static_cast<int32_t>(values_.size());
    const auto [place, is_new] = known_.emplace(table, next);
    for (const auto& [from, bits] : table) {
        if (is_new) values_.push_back({from, bits});
    }
    return place->second;
}

/// Makes a Pick a Table if all its elements are constants or values of the object.
bool TableFormer::make_table(const ir::Stage& stage, Instr* pick) {
    std::vector<std::pair<int32_t, uint32_t>> table;
    for (size_t k = 1; k < pick->args.size(); ++k) {
        const Instr& element = stage.instrs[pick->args[k]];
        if (element.op == Op::kConst) {
            table.emplace_back(kConstant, element.bits);
        } else if (element.op == Op::kInput && element.kind == OPENFAB_ARG_UNIFORM) {
            table.emplace_back(element.a, 0);
        } else {
            return false;
        }
    }
    const int32_t first = table[0].first;
    const int32_t step = table.size() > 1 ? table[1].first - first : 1;
    bool even = first != kConstant && step > 0;
    for (size_t k = 0; k < table.size() && even; ++k)
        even = table[k].first == first + step * static_cast<int32_t>(k);
    pick->op = Op::kTable;
    pick->bits = static_cast<uint32_t>(table.size());
    pick->a = even ? first : index_of(table);
    pick->b = even ? step : 1;
    pick->args.resize(1);
    return true;
}

void TableFormer::form(ir::Stage* stage) {
    const bool any = std::any_of(stage->instrs.begin(), stage->instrs.end(),
                                 [](const Instr& instr) { return instr.op == Op::kPick; });
    if (!any) return;
    const std::vector<bool> live = ir::live_values(*stage);
    const ir::Stage old = std::exchange(*stage, {});
    stage->kind = old.kind;
    stage->printfs = old.printfs;
    ir::Builder builder(stage);
    std::vector<ValueId> renamed;
    renamed.reserve(old.instrs.size());
    for (ValueId id = 0; id < old.instrs.size(); ++id) {
        const Instr& instr = old.instrs[id];
        Instr copy = instr;
        for (ValueId& arg : copy.args)
            arg = renamed[arg];
        builder.set_span(instr.span);
        if (copy.op == Op::kPick && live[id] && !make_table(*stage, &copy)) {
            renamed.push_back(choose_element(copy, &builder));
        } else {
            renamed.push_back(builder.append(std::move(copy)));
        }
    }
    for (ir::Output output : old.outputs) {
        output.value = renamed[output.value];
        stage->outputs.push_back(std::move(output));
    }
    ir::drop_dead_values(stage);
}

}  // namespace openfab::passes
