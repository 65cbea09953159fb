// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a condition holds on every path, for what must be assigned or returned on every path:
// folding alone does not see that `if (a) … else if (b) … else …` leaves no gap once breaks and
// returns have been woven into it. Conditions are taken as formulas of and, or, not and select over
// comparisons and whatever else is a bool; of the comparisons it is known which are opposites.

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::sema {

/// True where `fact` holds whenever all of `given` do. False where that is not so, where it takes
/// more than the formulas to see it, and where they are too tangled for a bounded search.
bool follows(const ir::Stage& stage, const std::vector<ir::ValueId>& given, ir::ValueId fact);

}  // namespace openfab::sema
