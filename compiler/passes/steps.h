// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Loops, queries, prints and what belongs to them: steps of a stage, which keep their place and
/// are no mere function of their arguments.
constexpr bool is_step(ir::Op op) {
    switch (op) {
        case ir::Op::kLoop:
        case ir::Op::kLoopVar:
        case ir::Op::kLoopEnd:
        case ir::Op::kLoopResult:
        case ir::Op::kQuery:
        case ir::Op::kQueryResult:
        case ir::Op::kPrint:
            return true;
        default:
            return false;
    }
}

}  // namespace openfab::passes
