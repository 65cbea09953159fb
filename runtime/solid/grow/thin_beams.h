// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Beams that only a few voxels may be in, such as twigs as thin as a voxel: each is compared with these voxels as it is
// found, and neither gathered nor sorted into a tree. What holds no voxel's centre is not even grown.

#include "runtime/solid/coverage_strips.h"
#include "runtime/solid/grow/grown.h"
#include "runtime/solid/tops.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

class ThinBeams final : public Sieve {
  public:
    /// Of the slices `bits` of a slab, in columns that are in the mask, which gets what is covered. `base` as
    /// part_base_voxel.
    ThinBeams(const Grown& grown, const VoxelFrame& frame, const Columns& columns, int32_t slab,
              uint8_t bits, const Vec3i& base, voxel::SlabMask* out);

    bool reaches(const Box3f& box) const override;
    bool take(const GrownBeam& beam, const Box3f& box) override;

  private:
    /// Returns the voxels, part-relative, of the tile whose centres may be in a box; hi exclusive.
    Box3i voxels_in(const Box3f& box) const;

    const Grown& grown_;
    const VoxelFrame& frame_;
    const Vec3i base_;
    const uint8_t bits_;
    const bool straight_;
    Box3i tile_;   ///< voxels, part-relative
    int32_t low_;  ///< the lowest slice of the slab, part-relative
    Vec3d first_, per_voxel_, slack_;
    std::array<float, 8> z_{};  ///< of the slab's slices
    voxel::SlabMask* const out_;
};

}  // namespace openfab::solid
