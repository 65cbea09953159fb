// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether connectors and numbers of a piece leave each other room.

#include <string>

#include "pieces/region.h"

namespace openfab::pieces {

/// Returns what of the region is too near to what, or no text: between two connectors must be what the less
/// demanding of them asks for to the surface, and numbers must not run into them or each other. `*location` becomes
/// that of a connector where one is too near.
std::string collision(const Region& region, SourceLocation* location);

/// Returns the distance of two shapes (above their cuts), less at most 1e-4 mm.
double distance(const Shape& a, const Shape& b);

}  // namespace openfab::pieces
