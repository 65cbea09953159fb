// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What Part::shape points to: the part whose fablet's @Shape stage is a geometry, with what only such
// a part has.

#include <array>
#include <memory>
#include <vector>

#include "runtime/part/part.h"

namespace openfab::part {

struct ShapeStage : Part {
    /// The space of the part is so many times that of the stage, along each axis.
    std::array<double, 3> stretch{1, 1, 1};
    /// The geometry of what the stage asks for distances, each in its own place, by index among the
    /// Object uniforms; null where it does not. Empty if it asks none.
    std::vector<std::shared_ptr<const Part>> bodies;
};

/// Returns what Part::shape points to.
inline const ShapeStage& shape_stage(const Part& stage) {
    return static_cast<const ShapeStage&>(stage);
}

}  // namespace openfab::part
