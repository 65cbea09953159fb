// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the zero set of a shape may be and where it is for certain, in cubes of four cells, without its
// micropolygons: bounds of distances, for culling. Threads share it.
//
// Of a block of 16 cells a side (ShapeField::find_blocks) two masks of 64 cubes are found when it is
// first near: those that bounds of the value leave open, outside of which there is no micropolygon;
// and those with an edge between an inside and an outside vertex, in which there is one.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/solid/shape/near_boxes.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

/// Bounds of the distances, mm, of all points of a box to the micropolygons.
struct NearRange {
    float low = 0, high = 0;
};

class ShapeNear {
  public:
    /// Scratch memory of one thread.
    class Tools {
      public:
        friend class ShapeNear;

      private:
        std::vector<NearCube> cubes_;  ///< the first `count_` of them
        size_t count_ = 0;
        std::vector<NearRow> table_;
        NearBoxes boxes_;
        const ShapeNear* of_ = nullptr;
        NearCube
            last_{};  ///< one of `of_`, certain, near the last boxes: what is near the next is mostly not much farther
    };

    /// `blocks`: those of the field, in order of z, y, x; both must outlive it.
    ShapeNear(const ShapeField& field, std::span<const Vec3i> blocks);

    /// The side of a block.
    float block_mm() const { return block_mm_; }
    /// Bounds the distances of at most kMostNearBoxes boxes that `whole` holds. `high` is infinite where nothing is near.
    void bound(const Box3f& whole, std::span<const Box3f> boxes, Tools* tools,
               NearRange* out) const;

  private:
    struct Masks {
        std::atomic<uint64_t> possible{0};  ///< 0: not known yet
        std::atomic<uint64_t> certain{0};
    };
    void bound_boxes(std::span<const Box3f> boxes, float seen2, size_t close, Tools* tools) const;
    void add_row(int32_t y, int32_t z, int32_t x0, int32_t x1, const Box3f& whole, Tools* tools,
                 float* nearest2) const;
    void add_block(size_t block, const Box3f& whole, Tools* tools, float* nearest2) const;
    void find_masks(size_t block, uint64_t* possible, uint64_t* certain) const;

    const ShapeField& field_;
    std::span<const Vec3i> blocks_;
    Vec3i size_;                ///< of the lattice, blocks
    std::vector<size_t> rows_;  ///< [z][y]: the first block of the row, and one more
    std::unique_ptr<Masks[]> masks_;
    std::array<std::vector<float>, 3> edges_;  ///< by axis: coordinates of the cubes' sides
    NearKernels kernels_;
    float block_mm_;
    float largest_ = 0;  ///< coordinate
};

}  // namespace openfab::solid
