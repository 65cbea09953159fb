// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Puts dowels and numbers on the cuts of a tree.

#include "tools/split/coarse_solid.h"
#include "tools/split/search.h"

namespace openfab::pieces {

/// Puts up to two dowels and a number between each two pieces that meet at a cut. Returns how many such
/// pairs have no dowel, because none fits.
int32_t place_connectors(const Body& body, const CoarseSolid& solid, const SearchOptions& options,
                         Tree* tree);

}  // namespace openfab::pieces
