// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How crowded a displaced surface may be. The boxes of patches whose displacement is bounded by
// more than their distance to others overlap, as do those of a mesh that crosses itself; near each
// point lie the micropolygons of all of them, and a query has to look at many.

#include <vector>

#include "runtime/surface/surface.h"

namespace openfab::surface {

/// Returns how many micropolygons may lie around a point of the surface's box, on average: those of
/// displaced patches, times the share of it that their own boxes take. From bounds alone; nothing
/// is diced. Below 1,500 for parts that people print, above 9,000 for a mesh of 160 random
/// triangles between two balls.
double crowding(const std::vector<Patch>& patches);

/// Surfaces above this are crowded: they take many times as long as others.
constexpr double kCrowded = 4000;

}  // namespace openfab::surface
