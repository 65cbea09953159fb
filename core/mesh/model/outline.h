// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Areas of the plane bounded by polygons, for what is swept from them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::mesh {

using Point2 = Vec2<double>;
using Outline = std::vector<Point2>;

/// The most corners of the outlines of one area together: each is compared with each.
constexpr size_t kMostOutlineCorners = 2000;

/// Checks that the outlines bound an area: each of 3 corners or more, no two corners in a row at one
/// place, and no two sides that meet but at the corner they share. An error names the place; its
/// message continues "the polygon …".
Result<void> check_outlines(const std::vector<Outline>& outlines);

/// Turns each outline so that the area is on its left: an outline within an even number of others is
/// outer and counter-clockwise, one within an odd number bounds a hole and is clockwise. The first
/// corner stays the first. The outlines have passed check_outlines.
void orient_outlines(std::vector<Outline>* outlines);

/// A corner of an outline.
struct OutlineCorner {
    size_t outline = 0, corner = 0;
};

/// Splits the area between oriented outlines into triangles, counter-clockwise, whose corners are
/// those of the outlines.
std::vector<std::array<OutlineCorner, 3>> triangulate_area(const std::vector<Outline>& outlines);

/// The normals of the two sides at each corner of an oriented outline, of length 1: where it turns by
/// less than 30 degrees both are that of a smooth curve.
struct CornerNormals {
    Point2 before, after;
};
std::vector<CornerNormals> corner_normals(const Outline& outline);

}  // namespace openfab::mesh
