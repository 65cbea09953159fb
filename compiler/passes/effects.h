// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// True for loops, queries, printfs and their parts: they keep their order and are not pure
/// functions of their arguments.
constexpr bool is_effectful(ir::Op op) {
    switch (op) {
        case ir::Op::kLoop:
        case ir::Op::kLoopVar:
        case ir::Op::kLoopEnd:
        case ir::Op::kLoopResult:
        case ir::Op::kQuery:
        case ir::Op::kQueryResult:
        case ir::Op::kPrintf:
            return true;
        default:
            return false;
    }
}

}  // namespace openfab::passes
