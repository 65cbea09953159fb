// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Moves loop-invariant computations to before the loop. Texture lookups move too, guarded by the
/// loop's own guard; loops and queries stay.
void hoist_invariants(ir::Stage* stage);

}  // namespace openfab::passes
