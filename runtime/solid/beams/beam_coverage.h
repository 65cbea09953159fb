// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Coverage of beams on a grid: the sign of the least distance at voxel centres, in tiles that are halved
// while a beam may cross them.

#include <array>
#include <atomic>
#include <cstdint>

#include "runtime/solid/beams/beam_block.h"
#include "runtime/solid/tops.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

class BeamCoverage {
  public:
    /// `box`: voxels of the grid that they may cover, within the grid; `base` as part_base_voxel.
    BeamCoverage(const BeamTree& tree, const VoxelFrame& frame, const Box3i& box, const Vec3i& base)
        : tree_(tree), frame_(frame), box_(box), base_(base) {}

    static constexpr int32_t kLargest = 64;  ///< voxels along a side of a tile
    struct Tools {
        std::vector<int32_t> found;
        std::array<BeamList, 4> lists;  ///< of tiles of 64, 32, 16 and 8 voxels
        BeamList of_cube;
        BeamCube cube;
    };
    static Tools make_tools() { return {}; }

    const Box3i& box() const { return box_; }
    /// Covers columns [x0, x1) x [y0, y1), multiples of 8, of a slab in the mask.
    void cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop, Tools* tools,
               voxel::SlabMask* out) const;

  private:
    void cover_tile(int32_t slab, int32_t x, int32_t y, int32_t side,
                    std::span<const int32_t> beams, const Columns& columns, Tools* tools,
                    voxel::SlabMask* out) const;
    void cover_block(int32_t slab, int32_t x, int32_t y, std::span<const int32_t> beams,
                     Tools* tools, voxel::SlabMask* out) const;
    /// Sets the bits of columns [x, x + side) x [y, y + side) that lie in box and mask.
    void fill(int32_t x, int32_t y, int32_t side, uint8_t bits, voxel::SlabMask* out) const;

    const BeamTree& tree_;
    const VoxelFrame& frame_;
    const Box3i box_;
    const Vec3i base_;
};

}  // namespace openfab::solid
