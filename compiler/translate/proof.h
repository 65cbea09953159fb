// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Proves that a condition holds on every path, for values that must be assigned on every path:
// folding alone does not see that `if (a) … else if (b) … else …` is exhaustive once breaks and
// returns have been woven into it. Conditions are read as formulas of and, or, not and select over
// comparisons and other bools. Comparisons that are opposites are recognized, and those of one
// integer with several numbers: `n > 4` implies `n > 3`.

#include <cstddef>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::translate {

/// Returns whether `fact` provably holds whenever all of `given` do. False also if the proof needs
/// more than the formulas, or if they are too large for the bounded search.
bool follows(const ir::Stage& stage, const std::vector<ir::ValueId>& given, ir::ValueId fact);

}  // namespace openfab::translate
