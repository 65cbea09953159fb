// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/eliminate_common_values.h"

#include <map>
#include <tuple>

namespace openfab::passes {

namespace {

/// Never merges loops, queries or printfs: two equal printfs print twice.
bool stands_alone(ir::Op op) {
    return op == ir::Op::kLoop || op == ir::Op::kLoopVar || op == ir::Op::kLoopEnd ||
           op == ir::Op::kPrintf;
}

}  // namespace

void eliminate_common_values(ir::Stage* stage) {
    using Key =
        std::tuple<ir::Op, ir::Type, uint32_t, int32_t, int32_t, int32_t, std::vector<ir::ValueId>>;
    std::map<Key, ir::ValueId> first;
    std::vector<ir::ValueId> alias;
    for (ir::ValueId id = 0; id < stage->instrs.size(); ++id) {
        ir::Instr& instr = stage->instrs[id];
        for (ir::ValueId& arg : instr.args)
            arg = alias[arg];
        if (instr.op == ir::Op::kLoopEnd) {
            // Values of the loop are not available after it.
            const ir::ValueId loop = instr.args[0];
            std::erase_if(first, [&](const auto& item) { return item.second > loop; });
        }
        if (stands_alone(instr.op)) {
            alias.push_back(id);
            continue;
        }
        const Key key{instr.op, instr.type, instr.bits, instr.kind, instr.a, instr.b, instr.args};
        alias.push_back(first.emplace(key, id).first->second);
    }
    for (ir::Output& output : stage->outputs)
        output.value = alias[output.value];
}

}  // namespace openfab::passes
