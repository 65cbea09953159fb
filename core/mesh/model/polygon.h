// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::mesh {

/// Limit of the corner comparisons that triangulate makes for the concave polygons of one file: a
/// few seconds' worth. Typical polygons take a few dozen per corner.
constexpr int64_t kTriangulationEffort = 200'000'000;

/// Splits a polygon of n >= 3 corners, nearly flat, into n - 2 triangles of corner numbers that
/// keep its direction: a fan from corner 0 if it is convex, else ears clipped in order. Depends on
/// the corners alone. Decreases *effort by the corner comparisons, at most n^2; returns no
/// triangles once it is used up.
std::vector<std::array<int32_t, 3>> triangulate(const std::vector<Vec3d>& corners, int64_t* effort);

}  // namespace openfab::mesh
