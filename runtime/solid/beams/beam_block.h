// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Voxels of a block compared with a list of beams: cubes of 4 x 4 x 4 voxels at once, with the beams that
// can matter in each.

#include <array>
#include <span>
#include <vector>

#include "runtime/solid/beams/beam_tree.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

constexpr int32_t kCubeVoxels = 64;

/// The centres of a cube's voxels, [(y * 4 + x) * 4 + z], and what was found there.
struct alignas(32) BeamCube {
    float p[3][kCubeVoxels];
    float distance[kCubeVoxels];
    int32_t beam[kCubeVoxels];

    /// Takes the cube whose lowest voxel this is, part-relative.
    void set(const VoxelFrame& frame, const Vec3i& lowest);
    /// Finds the nearest of a list, which is in order of numbers.
    void find_nearest(const std::vector<BeamRecord>& beams, std::span<const int32_t> list);
    /// Finds the distance alone.
    void find_distance(const std::vector<BeamRecord>& beams, std::span<const int32_t> list);
};

/// A box of voxels as a ball around its middle.
struct VoxelBall {
    Vec3f middle;
    float radius = 0;  ///< that of the farthest centre, with a margin
};

/// Returns the ball of the centres of `size` voxels from `lowest`, part-relative.
VoxelBall voxel_ball(const VoxelFrame& frame, const Vec3i& lowest, const Vec3i& size);

/// Beams with their distances from the middle of a box of voxels.
class BeamList {
  public:
    /// Takes those that may be nearest to a point of the ball, of all, in order of numbers. `start`: a
    /// beam near it, or -1. Returns the nearest to the middle.
    NearestBeam gather(const BeamTree& tree, const VoxelBall& ball, int32_t start);
    /// Likewise of a list; it is not empty, and neither is the result.
    void gather(const BeamTree& tree, const VoxelBall& ball, std::span<const int32_t> of);
    /// Takes those that may hold a point of the ball. Returns whether one holds all of it.
    bool gather_holding(const BeamTree& tree, const VoxelBall& ball, std::span<const int32_t> of);

    std::span<const int32_t> beams() const { return beams_; }
    /// Returns the distance of the nearest from the middle, by the last two.
    float nearest() const { return nearest_; }

  private:
    std::vector<int32_t> beams_;
    std::vector<float> distances_;
    float nearest_ = 0;
};

}  // namespace openfab::solid
