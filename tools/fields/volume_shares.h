// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a volume stage says by its amounts: which materials may be there, and whether it may leave a
// point void, which in 3MF is a matter of the shape.

#include <cstdint>
#include <vector>

#include "tools/fields/fablet_ir.h"

namespace openfab::tools {

/// Returns whether the amounts of all these outputs are 0 on one of the ways that the stage's conditions
/// open. What is 0 by chance, as where a smooth amount ends, is not found, and counts as something.
bool may_be_void(const IrStage& stage, const std::vector<uint32_t>& amounts);

/// Returns the only amount that can be more than 0, by its place among them; -1 where there are several.
int only_amount(const IrStage& stage, const std::vector<uint32_t>& amounts);

}  // namespace openfab::tools
