// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/base/vec.h"

namespace openfab::scene {

/// Splits a polygon of n >= 3 corners, nearly flat, into n - 2 triangles of corner numbers that
/// keep its direction: a fan from corner 0 if it is convex, else ears clipped in order. Depends on
/// the corners alone.
std::vector<std::array<int32_t, 3>> triangulate(const std::vector<Vec3d>& corners);

}  // namespace openfab::scene
