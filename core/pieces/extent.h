// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a piece of a mesh is, and whether its connectors fit.

#include <array>
#include <span>
#include <string>

#include "base/vec.h"
#include "pieces/region.h"

namespace openfab::pieces {

/// A closed mesh.
struct Body {
    std::span<const Vec3d> positions;
    std::span<const std::array<int32_t, 3>> triangles;

    std::array<Vec3d, 3> triangle(size_t t) const;
    /// Returns whether the winding number of a point is above 0.
    bool holds(const Vec3d& p) const;
};

/// Returns the box of a piece under an affine map, exact: the boxes of all pieces of a mesh are that of
/// the mesh. Empty where it has nothing.
Box3d piece_box(const Body& body, const Region& region, const Affine3d& map);
/// Returns the box of what of a box is in the piece, under an affine map.
Box3d piece_box(const Box3d& box, const Region& region, const Affine3d& map);
/// Returns the box of the corners of a piece where three cuts meet in a box, under an affine map.
Box3d corner_box(const Box3d& box, const Region& region, const Affine3d& map);
/// Returns the box of what of a box is in the piece's pegs, under an affine map.
Box3d added_box(const Box3d& box, const Region& region, const Affine3d& map);
/// Returns whether a point of a box is on all sides, or may be.
bool may_hold(std::span<const Side> sides, const Box3f& box);
/// Adds to a box what of a triangle is on all sides, under an affine map.
void add_triangle(const std::array<Vec3d, 3>& triangle, std::span<const Side> sides,
                  const Affine3d& map, Box3d* out);

/// Returns what of the region does not fit, or no text: it reaches through another cut, or is nearer
/// than it may be to the surface, which may move by `moves_mm`. `*location` is the connector's.
std::string misfit(const Body& body, const Region& region, double moves_mm,
                   SourceLocation* location);

/// Returns the distance of a convex shape (above its cut) from a triangle, less at most 1e-4 mm.
double distance(const Shape& shape, const std::array<Vec3d, 3>& triangle);

}  // namespace openfab::pieces
