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
    /// Voxels along a side of what intervals decide at once.
    static constexpr int32_t kLargest = 64;
    /// Calls that are a thread's for as long as these live.
    struct Tools {
        explicit Tools(const ShapeField& of) : field(of), calls(of.take()) {}
        ~Tools() { field.give(calls); }
        Tools(const Tools&) = delete;
        Tools& operator=(const Tools&) = delete;

        const ShapeField& field;
        ShapeCalls* calls;
    };
    Tools make_tools() const { return Tools(field_); }

    /// Covers columns [x0, x1) x [y0, y1), multiples of 8, of a slab in the mask.
    void cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop, Tools* tools,
               voxel::SlabMask* out) const;

  private:
    /// Evaluates tiles; `points` and `values` are scratch memory.
    void evaluate(int32_t slab, std::span<const Vec2<int32_t>> tiles, ShapeCalls* calls,
                  ShapePoints* points, std::vector<float>* values, voxel::SlabMask* out) const;

    const ShapeField& field_;
    const VoxelFrame& frame_;
    const Box3i box_;
    const Vec3i base_;
};

}  // namespace openfab::solid
