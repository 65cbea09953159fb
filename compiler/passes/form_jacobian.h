// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Derivatives of a volume stage's fractions by uniforms, in forward mode: beside each value its changes, one for each
// direction, so that loops, queries and segments are those of the stage itself.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// The most directions of one stage.
constexpr size_t kMostDirections = 16;

/// A direction in the space of an object's values: by how much each of them changes.
struct Direction {
    struct Seed {
        int32_t value = 0;    ///< index of a float among the values
        int32_t weight = -1;  ///< of the value that says by how much; -1: by 1
    };
    std::vector<Seed> seeds;
};

/// What of a fablet has no derivative in some of the directions.
struct NoDerivative {
    source::Span span;
    std::string what;  ///< "a texture lookup whose coordinates depend on it"
};

struct Jacobian {
    /// Outputs WEIGHT: first the amounts of all slots; then for each direction the derivative of each slot's fraction
    /// (its amount by the sum of all; negative ones and NaN count as 0, as when a voxel's mixture is made). A branch
    /// or a step has the derivative of what it took. Without outputs where `none` has any.
    ir::Stage stage;
    std::vector<NoDerivative> none;
};

/// Forms that stage from the fablet's volume, as the front end gives it.
Jacobian form_jacobian(const ir::Fablet& fablet, std::span<const Direction> directions);

}  // namespace openfab::passes
