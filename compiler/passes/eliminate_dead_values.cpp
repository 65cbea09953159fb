// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/eliminate_dead_values.h"

namespace openfab::passes {

void eliminate_dead_values(ir::Stage* stage) {
    ir::drop_dead_values(stage);
}

}  // namespace openfab::passes
