// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Between which numbers the values of a stage are, wherever in a box it is asked: for what a float cannot say exactly.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "tools/fields/fablet_ir.h"

namespace openfab::tools {

/// The least and the most, without the undefined values.
struct ValueBounds {
    double lo = -std::numeric_limits<double>::infinity();
    double hi = std::numeric_limits<double>::infinity();
};

struct StagePlace {
    std::array<ValueBounds, 3> point;         ///< of a shape stage, by axis
    std::array<double, 3> scale = {1, 1, 1};  ///< times these of a volume stage
};

/// Returns the bounds of each line's value, without the rounding of floats; of what functions of 3MF cannot
/// say, none. `undefined`: by line, whether the value may be so.
std::vector<ValueBounds> stage_bounds(const IrStage& stage, std::span<const uint32_t> uniforms,
                                      const StagePlace& place, const std::vector<bool>& undefined);

}  // namespace openfab::tools
