// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rectangles of faces between two codes, and their triangles.
//
// Points on the mesh are in half voxels: lattice points have even coordinates, midpoints of edges
// one odd one.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::boundary {

/// Faces in one plane across `axis`, all between the codes low (towards -axis) and high. u and v
/// are the axes of the plane: (x, y) across z, (x, z) across y, (y, z) across x.
struct Rectangle {
    int32_t axis = 2;
    int32_t plane = 0;  ///< lattice coordinate along axis
    int32_t u0 = 0, u1 = 0, v0 = 0, v1 = 0;
    uint8_t low = 0, high = 0;
    uint32_t low_color = 0,
             high_color = 0;  ///< of the voxels on both sides, where there are colours

    int32_t u_axis() const { return axis == 0 ? 1 : 0; }
    int32_t v_axis() const { return axis == 2 ? 1 : 2; }
    /// Returns whether u, v, axis are right-handed, so that what is counter-clockwise in (u, v)
    /// faces +axis.
    bool right_handed() const { return axis != 1; }
    /// Returns a point of the mesh, in half voxels.
    Vec3i point(int32_t u2, int32_t v2) const;
};

/// The points of a mesh along the sides of a rectangle, in half voxels, in rising order. The rows
/// have the corners, the columns do not.
struct Outline {
    std::vector<int32_t> bottom, top;  ///< u at v0 and v1
    std::vector<int32_t> left, right;  ///< v at u0 and u1

    size_t size() const { return bottom.size() + top.size() + left.size() + right.size(); }
    void clear();
};

/// Lists the points in the order bottom, top, left, right.
void list_points(const Rectangle& rectangle, const Outline& outline, std::vector<Vec3i>* points);

/// Triangulates all points of the outline without degenerate triangles, as indices in the list of
/// list_points, counter-clockwise in (u, v).
void triangulate(const Outline& outline, std::vector<std::array<int32_t, 3>>* triangles);

}  // namespace openfab::boundary
