// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of the IR's operations, by forward-mode differentiation (dual numbers): for texture footprints
// (attach_footprints) and for fields (compiler/translate).

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::functions {

/// What the derivative of a square root of 0 is.
enum class AtZero {
    kQuotient,  ///< what its argument's is, divided by 0
    kZero,      ///< 0, as in the middle of a length
};

/// Returns the arguments whose changes decide that of a float; none of what counts as constant: integers, rounding,
/// comparisons, lookups, queries, loops.
std::vector<ir::ValueId> differentiable_args(const ir::Instr& instr);

/// Returns the change of `value`, whose instruction is `instr`, in the stage that `builder` writes, when its arguments
/// change by `changes`: one for each, of which those of differentiable_args() count. kNoValue means no change, in both.
ir::ValueId differentiate(ir::ValueId value, const ir::Instr& instr,
                          const std::vector<ir::ValueId>& changes, AtZero at_zero,
                          ir::Builder* builder);

}  // namespace openfab::functions
