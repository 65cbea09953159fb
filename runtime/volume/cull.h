// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which blocks of a group need no voxel-by-voxel work: the interval form of the volume stage over
// cubes of 64, 32, 16 and 8 voxels a side, from large to small. Where every slot's weight has one
// value only, that value is what the volume kernel would give, so culling never shows in the
// output.

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/print_part.h"
#include "runtime/voxel/coverage.h"

namespace openfab::slab {

/// A square of blocks with as many layers below and above.
struct CullCube {
    int32_t x, y;  ///< block columns and rows, multiples of the cube's side
};

/// One part in one group. Memory is kept from group to group.
class PartCull {
  public:
    /// Cubes bounded at once: many kernel calls' worth, few megabytes.
    static constexpr size_t kMostCubes = 4096;
    static constexpr int32_t kEvaluate = -1;
    static constexpr int32_t kNotCovered = -2;

    /// A composition that fills whole blocks.
    struct Constant {
        std::vector<float> weights;  ///< by slot
        bool mixed = false;
        uint8_t code = 0;            ///< where it is pure
        std::vector<uint8_t> codes;  ///< 512, for merging where it is mixed
        std::vector<uint16_t> tile;
    };

    /// `cull` off: every covered block is evaluated. `room`: bytes that compositions may still
    /// take, of this part and those that are culled beside it; when it is used up, blocks of others
    /// are evaluated.
    abi::KernelStatus run(const PrintPart& part, int32_t group, const voxel::GroupMask& mask,
                          bool cull, BlockEvaluator* evaluator, std::atomic<int64_t>* room);

    /// Rectangle of blocks that the mask covers.
    int32_t first_x() const { return first_x_; }
    int32_t end_x() const { return first_x_ + blocks_x_; }
    int32_t first_y() const { return first_y_; }
    int32_t end_y() const { return first_y_ + blocks_y_; }
    /// kEvaluate, kNotCovered, or the index of the block's composition.
    int32_t at(int32_t x, int32_t y) const {
        return blocks_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
    }
    /// Whether parts of the blocks that are left may hold one composition only, too: not where no
    /// cube did.
    bool finer() const { return finer_; }
    /// Blocks of kEvaluate.
    int64_t blocks_to_evaluate() const;
    const Constant& constant(int32_t index) const { return constants_[static_cast<size_t>(index)]; }

  private:
    void mark_covered(const voxel::GroupMask& mask);
    bool any_covered(const CullCube& cube, int32_t side) const;
    abi::KernelStatus add_constant(const PrintPart& part, const float* weights,
                                   BlockEvaluator* evaluator, std::atomic<int64_t>* room,
                                   int32_t* index);
    /// Bounds the cubes and fills those that can hold one composition only; the others replace
    /// them.
    abi::KernelStatus settle(const PrintPart& part, int32_t group, int32_t side, QueryBounds from,
                             BlockEvaluator* evaluator, std::atomic<int64_t>* room,
                             std::vector<CullCube>* cubes);
    void fill(const CullCube& cube, int32_t side, int32_t composition);
    abi::KernelStatus try_finer(const PrintPart& part, int32_t group, BlockEvaluator* evaluator);

    int32_t first_x_ = 0, first_y_ = 0, blocks_x_ = 0, blocks_y_ = 0;
    std::vector<int32_t> blocks_;
    std::vector<Constant> constants_;
    std::vector<Vec3i> lowest_;  ///< of the cubes in hand
    bool finer_ = false;
};

}  // namespace openfab::slab
