// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "base/vec.h"

namespace openfab::surface {

/// Returns the interval, low and high, that a box covers on an axis after an affine map, in the
/// order of operations of Affine3d::apply: rounding is monotone, so no point of the box maps
/// outside, and flat sides of an axis-aligned part map exactly.
inline Vec2<double> transform_range(const Affine3d& map, const Box3f& box, int row) {
    double lo = 0, hi = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double m = map.m[static_cast<size_t>(3 * row + axis)];
        const double a = m * static_cast<double>(box.lo[axis]);
        const double b = m * static_cast<double>(box.hi[axis]);
        lo = axis == 0 ? std::min(a, b) : lo + std::min(a, b);
        hi = axis == 0 ? std::max(a, b) : hi + std::max(a, b);
    }
    return {lo + map.t[row], hi + map.t[row]};
}

/// Returns the box of a box's image: transform_range along all axes.
inline Box3d transform_box(const Affine3d& map, const Box3f& box) {
    Box3d out;
    for (int row = 0; row < 3; ++row) {
        const Vec2<double> range = transform_range(map, box, row);
        out.lo[row] = range.x;
        out.hi[row] = range.y;
    }
    return out;
}

}  // namespace openfab::surface
