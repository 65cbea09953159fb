// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expands every function (sin, pow, noise) into primitive operations, in place. Runs last: the
// passes before it know a function's derivative and interval, which its operations no longer show.
// Lowering knows primitive operations only, so the pass cannot be switched off.

#include "compiler/ir/ir.h"

namespace openfab::passes {

void expand_functions(ir::Stage* stage);

}  // namespace openfab::passes
