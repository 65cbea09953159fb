// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tables of curves (abi/curve_table.h) from their keys in the world.

#include <cstdint>
#include <string>
#include <vector>

#include "world/world.h"

namespace openfab::part {

/// Makes the table of a curve with that many channels. Monotone cubics have the slopes of Fritsch and Butland, "A method
/// for constructing local monotone piecewise cubic interpolants" (SIAM J. Sci. Stat. Comput. 5, 1984): no key is passed,
/// and none between them.
std::vector<float> curve_table(const world::Curve& curve, int32_t channels);

/// Returns how that table changes with the value of one of its keys in one of its channels.
std::vector<float> curve_change(const world::Curve& curve, int32_t channels, size_t key,
                                int32_t channel);

/// Returns what is wrong with keys for that many channels; empty if nothing is.
std::string curve_fault(const world::Curve& curve, int32_t channels);

}  // namespace openfab::part
