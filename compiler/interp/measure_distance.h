// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a shape that claims to be a distance is one: measured, since no formula shows it.

#include <array>
#include <optional>

#include "compiler/ir/ir.h"

namespace openfab::interp {

/// Where a shape was found not to be a distance.
struct NoDistance {
    std::array<float, 3> at{};  ///< mm, in part space
    float value = 0;            ///< there
    /// At the point that far against the gradient, where a distance is 0; or, where `other` holds a point, there:
    /// the two values differ by more than the points are apart.
    float then = 0;
    std::optional<std::array<float, 3>> other;
    float half = 0;   ///< the cube about the origin that was looked at, half of its edge
    float share = 0;  ///< of its points on this side of the surface that are such
};

/// Evaluates a shape at random points of a cube in which it has an inside and an outside, with the defaults of its
/// uniforms. Nothing where no fault was found: that of a distance, where it is not asked (a uniform without a
/// default, a texture), or has no surface within 500 mm of the origin.
std::optional<NoDistance> measure_distance(const ir::Fablet& fablet);

}  // namespace openfab::interp
