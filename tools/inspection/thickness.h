// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Walls, wires, gaps and holes that are thinner than a limit, from voxels: what an opening by a ball of that
// diameter removes, without the edges and corners of what is thick.

#include <cstdint>
#include <vector>

#include "tools/inspection/bits.h"

namespace openfab::inspection {

/// Something that is thinner than was asked for.
struct Thin {
    Cluster where;
    std::vector<Vec3i> voxels;   ///< of its surface
    std::vector<Vec3i> middles;  ///< some of those that are deepest in it
    double thickness_mm = 0;     ///< the mean of the largest balls there
};

/// The sine of half the angle of a wedge, 47 degrees, from which on its edge is an edge, and no thin wall.
constexpr double kEdgeSlope = 0.4;

/// Finds what is thinner than a limit. A ball of diameter `below_mm` fits where no voxel centre of the other kind is
/// nearer to its centre than its radius; its centre lies on a centre, corner, edge or face of a voxel. So
/// `below_mm` is more than the thickness of what is just found: one voxel more for plates along an axis, up to one for
/// others.
///
/// What no ball reaches counts, but for edges. An edge is within (r - d) / kEdgeSlope of the centre of a ball of
/// radius r, on a way within the body, if it is itself d deep; it is that for the limit's r, and for all smaller ones.
/// A place halfway between two balls is none. `outside`: whether what is beyond the box counts as set.
std::vector<Thin> find_thin(Bits bits, int outside, const Vec3d& pitch_mm, double below_mm);

/// Returns by how many voxels find_thin enlarges the box at each side.
Vec3i thin_margin(int outside, const Vec3d& pitch_mm, double below_mm);

}  // namespace openfab::inspection
