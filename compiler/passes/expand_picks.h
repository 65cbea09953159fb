// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// Leaves Picks of uniform values only, which become tables (form_tables). An arithmetic series of
/// integers, such as the materials of an array, is computed from the index; of values that differ
/// from voxel to voxel one is chosen after the other.
void expand_picks(ir::Stage* stage);

/// Emits the choice of one element after the other; `pick` has arguments of the builder's stage.
ir::ValueId choose_element(const ir::Instr& pick, ir::Builder* builder);

}  // namespace openfab::passes
