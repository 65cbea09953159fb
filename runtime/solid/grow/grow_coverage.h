// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Coverage of what grows: of each tile of voxels the beams are gathered, which are then covered as beams are.

#include <array>
#include <span>

#include "runtime/solid/beams/beam_coverage.h"
#include "runtime/solid/grow/local_beams.h"

namespace openfab::solid {

class GrowCoverage {
  public:
    /// As BeamCoverage.
    GrowCoverage(const Grown& grown, const VoxelFrame& frame, const Box3i& box, const Vec3i& base)
        : grown_(grown), frame_(frame), box_(box), base_(base) {}

    const Box3i& box() const { return box_; }

    static constexpr int32_t kLargest = BeamCoverage::kLargest;
    struct Tools {
        GatheredBeams gathered;
        LocalBeams local;
        BeamCoverage::Tools of_beams;
    };
    static Tools make_tools() { return {}; }
    void cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop, Tools* tools,
               voxel::SlabMask* out) const;

  private:
    void cover_tile(int32_t slab, const Columns& tile, const std::atomic<bool>* stop, Tools* tools,
                    voxel::SlabMask* out) const;
    struct BodyBox {
        const GrownBody* body;
        Box3f box;  ///< part space
    };
    void cover_bodies(int32_t slab, std::array<int32_t, 2> at, int32_t side,
                      std::span<const BodyBox> bodies, const Columns& columns,
                      voxel::SlabMask* out) const;
    void cover_block(int32_t slab, std::array<int32_t, 2> at, std::span<const BodyBox> bodies,
                     voxel::SlabMask* out) const;

    const Grown& grown_;
    const VoxelFrame frame_;
    const Box3i box_;
    const Vec3i base_;
};

}  // namespace openfab::solid
