// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A placed solid whose coverage is decided tile by tile.

#include "runtime/solid/coverage_strips.h"
#include "runtime/solid/placed_box.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

/// `Coverage` is made of what covers, which has bounds; it covers strips of tiles, kLargest voxels a side, with tools of
/// one thread.
template <typename Coverage>
class PlacedTiles : public Placed {
  public:
    template <typename Content>
    PlacedTiles(const Content& content, const Place& where)
        : frame_(where.frame),
          voxels_(where.frame),
          coverage_(content, voxels_, voxels_of(where, content.bounds()),
                    part::part_base_voxel(where.part, where.grid)) {}

    Box3i voxel_box() const override { return coverage_.box(); }
    void coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                  double* seconds) const override {
        cover_strips(coverage_.box(), slab, Coverage::kLargest, out, seconds,
                     [&](const Columns& columns) {
                         auto tools = coverage_.make_tools();
                         coverage_.cover(slab, columns, stop, &tools, out);
                     });
    }
    void raise_tops(const Columns& columns, TopRows* rows) const override {
        auto tools = coverage_.make_tools();
        raise_to_covered(coverage_.box(), columns, rows,
                         [&](int32_t slab, const Columns& all, voxel::SlabMask* mask) {
                             coverage_.cover(slab, all, nullptr, &tools, mask);
                         });
    }

  protected:
    const std::array<float, OPENFAB_FRAME_COUNT> frame_;
    const VoxelFrame voxels_;

  private:
    const Coverage coverage_;
};

}  // namespace openfab::solid
