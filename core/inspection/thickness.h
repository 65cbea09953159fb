// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How thick walls, gaps, wires and holes are, from voxels. Along the normal of a plate the smoothed voxels
// sum up to its thickness, whatever its angle, since smoothing moves nothing: that is exact to a
// fraction of a voxel where distances of voxel centres are not. The normal is the main axis of the
// gradients around a place on the surface. An edge of a thick body has two main axes of which one leads
// into its depth, so that edges and corners are not taken for something thin; a wire has two that are
// both short.

#include <cstdint>
#include <vector>

#include "inspection/bits.h"

namespace openfab::inspection {

/// Something that is thinner than was asked for.
struct Thin {
    Cluster where;
    std::vector<Vec3i> voxels;  ///< of its surface
    double thickness_mm = 0;    ///< the mean over its surface
    bool in_all_ways = false;   ///< across two directions or three: a wire or a hole
};

struct ThinLimits {
    double plate_mm = 0;  ///< of what is thin along one direction; 0: do not look
    double wire_mm = 0;   ///< along two
    double slack_mm = 0;  ///< what is thinner by less is none: what voxels cannot tell
};

/// Finds what is thinner than the limits. Voxels at three times the pitch that a limit is a whole number of
/// tell k of these from k + 1 at any angle, with a slack of 0.4: at 45 degrees layers are 0.24 apart. `outside`: whether what is
/// beyond the box counts as set.
std::vector<Thin> find_thin(const Bits& bits, int outside, const Vec3d& pitch_mm,
                            const ThinLimits& limits);

}  // namespace openfab::inspection
