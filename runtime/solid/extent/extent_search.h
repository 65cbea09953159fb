// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far a solid, or a piece of one, reaches along the axes of a turned space: what the box of its
// vertices is for a mesh. Nothing of it depends on the pitch of a print.

#include <array>
#include <span>
#include <vector>

#include "base/vec.h"
#include "pieces/region.h"

namespace openfab::solid {

/// How far a solid reaches under a linear map.
struct Extent {
    Box3d box;  ///< empty: nowhere is a point of it
    std::vector<Box3f>
        open;  ///< boxes, part-local, beyond it, where bounds of the value do not tell that nothing is inside
    double spacing_mm = 0;  ///< of an empty box with open ones: points so far apart were looked at
};

/// A solid as a value that is negative inside, part-local mm. Threads share it.
class SolidValue {
  public:
    virtual ~SolidValue() = default;
    /// Returns a box that holds the solid.
    virtual Box3f box() const = 0;
    virtual void values(std::span<const Vec3f> points, float* out) const = 0;
    /// Computes numbers with the signs of the values, where these are dearer.
    virtual void signs(std::span<const Vec3f> points, float* out) const { values(points, out); }
    /// Computes what values in the boxes are not below; NaN where nothing is known.
    virtual void lower_bounds(std::span<const Box3f> boxes, float* out) const = 0;
};

/// Searches the extent of what of a solid is on all these sides, under a linear map whose rows are of
/// length 1, by boxes that are halved: those that bounds of the value decide are dropped, and points in
/// the rest show what is reached for certain.
Extent find_extent(const SolidValue& solid, const std::array<double, 9>& turn,
                   std::span<const pieces::Side> sides);

}  // namespace openfab::solid
