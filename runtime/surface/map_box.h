// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "base/vec.h"

namespace openfab::surface {

/// What a box covers of an axis after an affine map, low and high, in the order of operations of
/// Affine3d::apply: rounding is monotone, so no point of the box is mapped outside, and flat sides
/// of an axis-aligned part are mapped exactly.
inline Vec2<double> map_range(const Affine3d& map, const Box3f& box, int row) {
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

/// Image of a box: map_range along all axes.
inline Box3d map_box(const Affine3d& map, const Box3f& box) {
    Box3d out;
    for (int row = 0; row < 3; ++row) {
        const Vec2<double> range = map_range(map, box, row);
        out.lo[row] = range.x;
        out.hi[row] = range.y;
    }
    return out;
}

}  // namespace openfab::surface
