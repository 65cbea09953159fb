// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Coverage of a shape on a grid: the sign of its value at voxel centres. Blocks that intervals decide
// are not evaluated.

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/solid/shape/shape_field.h"
#include "runtime/solid/tops.h"
#include "runtime/solid/voxel_frame.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

class ShapeCoverage {
  public:
    /// `box`: voxels of the grid that it may cover, within the grid; `base` as part_base_voxel.
    ShapeCoverage(const ShapeField& field, const VoxelFrame& frame, const Box3i& box,
                  const Vec3i& base)
        : field_(field), frame_(frame), box_(box), base_(base) {}

    const Box3i& box() const { return box_; }
    /// As Placed::coverage.
    void coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                  double* seconds) const;
    /// Raises tops to the highest voxel that is covered in each column.
    void raise_tops(const Columns& columns, TopRows* rows) const;

  private:
    /// Covers columns [x0, x1) x [y0, y1), multiples of 8, of a slab in the mask.
    void cover(int32_t slab, const Columns& columns, ShapeCalls* calls,
               const std::atomic<bool>* stop, voxel::SlabMask* out) const;
    /// Evaluates tiles; `points` and `values` are scratch memory.
    void evaluate(int32_t slab, std::span<const Vec2<int32_t>> tiles, ShapeCalls* calls,
                  ShapePoints* points, std::vector<float>* values, voxel::SlabMask* out) const;

    const ShapeField& field_;
    const VoxelFrame& frame_;
    const Box3i box_;
    const Vec3i base_;
};

}  // namespace openfab::solid
