// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Computes equal instructions (operation, type, bits, input, arguments) once.
void eliminate_common_values(ir::Stage* stage);

}  // namespace openfab::passes
