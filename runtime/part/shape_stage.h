// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The stage of a shape or of what grows: the part whose fablet's @Shape or @Grow stage is a geometry, with its
// uniform values and textures. Its mesh is the box.

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

/// Returns the stage that a part's geometry is made by; null of geometry without.
inline const ShapeStage* stage_of(const Part& part) {
    return std::visit(
        [](const auto& of) -> const ShapeStage* {
            if constexpr (requires { of.stage; }) return of.stage.get();
            return nullptr;
        },
        part.geometry);
}

}  // namespace openfab::part
