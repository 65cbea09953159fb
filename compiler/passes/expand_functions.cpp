// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/expand_functions.h"

#include <algorithm>
#include <utility>

#include "compiler/functions/functions.h"

namespace openfab::passes {

void expand_functions(ir::Stage* stage) {
    const bool any = std::any_of(stage->instrs.begin(), stage->instrs.end(),
                                 [](const ir::Instr& instr) { return ir::is_function(instr.op); });
    if (!any) return;
    const std::vector<ir::Instr> old = std::exchange(stage->instrs, {});
    ir::Builder builder(stage);
    std::vector<ir::ValueId> renamed;
    renamed.reserve(old.size());
    for (const ir::Instr& instr : old) {
        ir::Instr copy = instr;
        for (ir::ValueId& arg : copy.args)
            arg = renamed[arg];
        builder.set_span(instr.span);
        renamed.push_back(ir::is_function(copy.op) ? functions::expand(copy, &builder)
                                                   : builder.append(std::move(copy)));
    }
    for (ir::Output& output : stage->outputs)
        output.value = renamed[output.value];
}

}  // namespace openfab::passes
