// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slivers and crumbs: what a cut takes off a part, and is thinner than anybody wants to hold.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "pieces/extent.h"
#include "pieces/tree.h"

namespace openfab::pieces {

/// What lies beyond a cut, and nowhere farther than this, is a sliver.
constexpr double kSliver_mm = 1;

struct Sliver {
    int32_t cut = 0;
    double thickness_mm = 0;
    Vec3d at;            ///< where it is farthest from the cut
    bool front = false;  ///< on that side of the cut
};

/// Returns the slivers of all cuts of a tree.
std::vector<Sliver> find_slivers(const Body& body, const Tree& tree);

/// Moves cuts by less than kSliver_mm where that leaves fewer slivers, and all pieces still fit the tray.
void avoid_slivers(const Body& body, const Vec3d& tray_mm, Tree* tree);

}  // namespace openfab::pieces
