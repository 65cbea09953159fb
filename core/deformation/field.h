// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A displacement of space: what is at p is moved to p + u(p). It is known at the nodes of a grid and linear
// along each axis between them. Beyond the grid it is that of its border.

#include <cstddef>
#include <optional>
#include <vector>

#include "base/vec.h"

namespace openfab::deformation {

struct Field {
    Vec3d origin_mm;  ///< the lowest node
    Vec3d spacing_mm{1, 1, 1};
    Vec3i nodes;              ///< at least 1 along each axis
    std::vector<Vec3d> u_mm;  ///< x fastest

    size_t at(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(nodes.y) + static_cast<size_t>(y)) *
                   static_cast<size_t>(nodes.x) +
               static_cast<size_t>(x);
    }
    Vec3d displacement(const Vec3d& p_mm) const;
    Vec3d moved(const Vec3d& p_mm) const { return p_mm + displacement(p_mm); }
    /// Returns the place that is moved to `p_mm`, to 1e-7 mm, if that is found: always where steepest() is below
    /// 0.5.
    std::optional<Vec3d> moved_back(const Vec3d& p_mm) const;
    /// Returns by how much neighbouring nodes are moved differently at most, of the distance between them.
    double steepest() const;
};

}  // namespace openfab::deformation
