// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Drops instructions that no output or printf needs and renumbers the rest.
void eliminate_dead_values(ir::Stage* stage);

}  // namespace openfab::passes
