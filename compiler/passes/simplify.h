// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Folds constants with the interpreter's own arithmetic and applies identities that hold for every
/// bit pattern (x * 1, x - 0, select on a constant, …; not x + 0, which loses -0). Values that
/// become unused stay in the list.
void simplify(ir::Stage* stage);

}  // namespace openfab::passes
