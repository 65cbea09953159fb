// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/eliminate_common_values.h"

#include <map>
#include <tuple>

namespace openfab::passes {

void eliminate_common_values(ir::Stage* stage) {
    using Key =
        std::tuple<ir::Op, ir::Type, uint32_t, int32_t, int32_t, int32_t, std::vector<ir::ValueId>>;
    std::map<Key, ir::ValueId> first;
    std::vector<ir::ValueId> alias;
    for (ir::ValueId id = 0; id < stage->instrs.size(); ++id) {
        ir::Instr& instr = stage->instrs[id];
        for (ir::ValueId& arg : instr.args)
            arg = alias[arg];
        const Key key{instr.op, instr.type, instr.bits, instr.kind, instr.a, instr.b, instr.args};
        alias.push_back(first.emplace(key, id).first->second);
    }
    for (ir::Output& output : stage->outputs)
        output.value = alias[output.value];
}

}  // namespace openfab::passes
