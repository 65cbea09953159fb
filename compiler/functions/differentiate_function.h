// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of the IR's functions, for differentiate.

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::functions {

/// Returns the change of `value`, a function (ir::is_function) in the stage that `builder` writes,
/// when its arguments change by `changes`; kNoValue means no change, in both. Gradients of a noise
/// and cellular distances use differences over 1/32 of a step instead.
ir::ValueId differentiate_function(ir::ValueId value, const ir::Instr& function,
                                   const std::vector<ir::ValueId>& changes, ir::Builder* builder);

}  // namespace openfab::functions
