// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Crossings of triangles with rows of voxel centers along +x, in integers.
//
// Vertices are in 1/256 voxel. The sample of voxel (i, j, k) is (256 i + 128 + e, 256 j + 128 + e²,
// 256 k + 128 + e³) with an infinitesimal e > 0, so that no sample lies on a plane or edge. It
// follows that:
//  - a row meets an edge P -> Q (seen in y, z) on its left if E > 0,
//      E = dy (z - Pz) - dz (y - Py);
//    where E = 0 the perturbed sample has the sign of dy e³ - dz e²: left if dz < 0, or dz = 0 and
//    dy > 0
//  - a triangle that is a line in (y, z) is met by no row
//  - voxel i lies below the crossing x* iff 256 i + 128 < x*: as e outweighs e² and e³, equality
//    means it does not. So a crossing is the count c = ceil((x* - 128) / 256): voxels i < c lie
//    below it
// The winding number of voxel i is the sum of `turn` over the crossings of its row with c > i; turn
// is +1 where the row leaves the solid. For a closed surface that is minus the sum over c <= i.

#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::voxel {

constexpr int32_t kSnap = 256;  ///< units a voxel
/// Snapped coordinates are clamped to +-kFarthest (two million voxels), so that edge tests fit 64
/// bits.
constexpr int32_t kFarthest = 1 << 29;

/// A crossing of row (j, k): voxels i < c lie below it.
struct Crossing {
    int32_t k, j, c;
    int32_t turn;
};

/// The voxels of interest, hi exclusive; crossings beyond them in x move to the ends, which keeps
/// the sums.
struct Window {
    Vec3i lo, hi;
};

/// Returns floor(x + 0.5) of a coordinate in 1/256 voxel, clamped to +-kFarthest.
inline int32_t snap(double x256) {
    double x = x256 + 0.5;
    x = x < -kFarthest ? -kFarthest : x;
    x = x > kFarthest ? kFarthest : x;
    const int32_t truncated = static_cast<int32_t>(x);
    return truncated - (x < truncated ? 1 : 0);
}

/// Returns the first voxel whose perturbed center is above a snapped coordinate: rows
/// [first_row(lo), first_row(hi)) lie between.
inline int32_t first_row(int32_t snapped) {
    return (snapped + 127) >> 8;
}

/// Appends the crossings of rows in the window with one triangle. `turn` is +1, or -1 where the map
/// to voxels mirrors.
void add_crossings(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn,
                   const Window& window, std::vector<Crossing>* out);

/// Appends the crossings of columns of voxel centers along +z: a crossing of column (i, j) has i in
/// `j`, j in `k`, and c counts from below. Samples are the same, so over a closed surface a voxel
/// has the same winding number from its row and from its column. One rule differs: if a crossing
/// falls on a sample's height, the perturbed sample lies below it if the triangle rises along +x,
/// or is level along x and rises along +y, as e moves the sample along x before e³ lifts it.
void add_column_crossings(const Vec3i& a, const Vec3i& b, const Vec3i& c, int32_t turn,
                          const Window& window, std::vector<Crossing>* out);

}  // namespace openfab::voxel
