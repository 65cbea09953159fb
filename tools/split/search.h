// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds cuts by which the pieces of a part fit a machine, after Chopper (Luo, Baran, Rusinkiewicz and
// Matusik, SIGGRAPH Asia 2012): planes as a tree, by beam search, on a coarse solid of voxels. In space
// of the part as printed, mm.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "pieces/extent.h"
#include "pieces/tree.h"
#include "tools/split/slivers.h"

namespace openfab::pieces {

struct SearchOptions {
    Vec3d tray_mm;      ///< largest size of a piece, in any of the six right-angled poses
    double peg_mm = 6;  ///< diameter of pegs; 0: no connectors
    double clearance_mm = 0.1;
    double skin_mm = 1.5;      ///< of pegs
    double number_mm = 6;      ///< height of numbers; 0: none
    int32_t beam = 4;          ///< trees that are kept
    int64_t voxels = 400'000;  ///< of the coarse solid, about
    /// Returns how much a seam at a point of the surface is disliked: 0 where it should be, 1 usual.
    std::function<double(const Vec3d&)> seam;
    /// Returns what a section through a point of the part takes on, as a stress: at least 0.
    std::function<double(const Vec3d&)> stress;
};

struct Found {
    Tree tree;
    int32_t pieces = 0;
    int32_t least = 0;  ///< of its box, or of the best grid over that where there are too many ways
    int32_t looked_at = 0;  ///< planes
    double voxel_mm = 0;
    double seam_mm2 = 0;  ///< of the surface that lies along cuts, in voxels' faces, as disliked
    int32_t without_peg = 0;      ///< cuts whose section holds no peg
    std::vector<Sliver> slivers;  ///< that are left
};

/// Returns whether a box fits the tray in a right-angled pose.
bool fits(const Vec3d& size_mm, const Vec3d& tray_mm);
/// Returns how many pieces the best grid over a box has.
int32_t pieces_of_box(const Vec3d& size_mm, const Vec3d& tray_mm);

/// Returns an error where no cuts are found.
Result<Found> find_cuts(const Body& body, const SearchOptions& options);

}  // namespace openfab::pieces
