// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounds the iterations of a loop by its test: one of its variables changes by at least a known
// step in each iteration and is compared with something whose range is known (a constant, or a
// value that min, max, clamp or a mask bounds).

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::translate {

/// Returns how often the loop runs at most; infinity if nothing is known. It is not ended yet:
/// `again` is its condition and `next` holds the next value of each LoopVar, as LoopEnd will have
/// them. `tests`, those of the enclosing loops, hold in each iteration.
double most_trips(const ir::Stage& stage, ir::ValueId loop, ir::ValueId again,
                  const std::vector<ir::ValueId>& next, const std::vector<ir::ValueId>& tests);

}  // namespace openfab::translate
