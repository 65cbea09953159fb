// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The stage of a shape or of what grows: the part whose fablet's @Shape or @Grow stage is a geometry, with its
// uniform values and textures. Its mesh is the box.

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "runtime/part/part.h"

namespace openfab::part {

struct ShapeStage : Part {
    /// The space of the part is so many times that of the stage, along each axis.
    std::array<double, 3> stretch{1, 1, 1};
    bool has_values_of_part =
        false;  ///< its uniforms are those of the part that it is the geometry of
    /// The geometry of what the stage asks for distances, each in its own place, by index among the
    /// Object uniforms; null where it does not. Empty if it asks none.
    std::vector<std::shared_ptr<const Part>> bodies;
};

/// Returns what values of a stage are multiplied by to be those of the part, if that is scaled alike
/// along all axes; else 0.
inline float scale_of_values(const ShapeStage& stage) {
    constexpr double kSlack = 1e-6;
    const auto [least, most] = std::ranges::minmax(stage.stretch);
    return most - least <= kSlack * least ? static_cast<float>(least) : 0.0f;
}

/// Returns that of a shape whose values are distances as they are declared; 0 of others.
inline float declared_scale(const ShapeStage& stage) {
    return stage.fablet->shape->is_distance != 0 ? scale_of_values(stage) : 0.0f;
}

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
