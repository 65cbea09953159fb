// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/eliminate_dead_values.h"

#include <utility>

namespace openfab::passes {

void eliminate_dead_values(ir::Stage* stage) {
    std::vector<bool> live(stage->instrs.size(), false);
    for (const ir::Output& output : stage->outputs)
        live[output.value] = true;
    for (size_t id = stage->instrs.size(); id-- > 0;) {
        if (!live[id]) continue;
        for (const ir::ValueId arg : stage->instrs[id].args)
            live[arg] = true;
    }
    std::vector<ir::ValueId> renamed(stage->instrs.size(), ir::kNoValue);
    std::vector<ir::Instr> kept;
    for (size_t id = 0; id < stage->instrs.size(); ++id) {
        if (!live[id]) continue;
        ir::Instr& instr = stage->instrs[id];
        for (ir::ValueId& arg : instr.args)
            arg = renamed[arg];
        renamed[id] = static_cast<ir::ValueId>(kept.size());
        kept.push_back(std::move(instr));
    }
    stage->instrs = std::move(kept);
    for (ir::Output& output : stage->outputs)
        output.value = renamed[output.value];
}

}  // namespace openfab::passes
