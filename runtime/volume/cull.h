// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds blocks of a slab that need no evaluation per voxel: the interval form of the volume stage
// over cubes of 64, 32, 16 and 8 voxels a side, from large to small. Where every slot's weight is a
// single value, the slab kernel would have that value, so culling never changes the output.

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/placed_part.h"
#include "runtime/voxel/coverage.h"

namespace openfab::volume {

/// A cube of blocks that contains the slab's layer.
struct CullCube {
    int32_t x, y;  ///< block columns and rows, multiples of the cube's side
    /// Of a cube in which no voxel has to know its nearest surface point: bounds of its distance,
    /// those of the largest such cube around it.
    CubeBounds::Range blind{};
    /// Its attributes that are known (CubeBounds::Known); null: none.
    const nearest::NearestCase* attributes = nullptr;
};

/// The culling of one part in one slab. Memory is reused from slab to slab.
class PartCull {
  public:
    /// Maximum number of cubes per kernel call: a few megabytes.
    static constexpr size_t kMostCubes = 4096;
    static constexpr int32_t kEvaluate = -1;
    static constexpr int32_t kNotCovered = -2;

    /// A mixture that fills whole blocks.
    struct Constant {
        std::vector<float> weights;  ///< by slot
        uint8_t code = 0;            ///< OPENFAB_CODE_MIXED where mixed
        ConstantColumn column;

        /// Merges it into a block of the band.
        void merge(int32_t block, const uint8_t* owned, const abi::Channels& channels,
                   dither::RowBand* band) const;
    };

    /// `cull` off: every covered block is evaluated. `room`: bytes that mixtures may still take, of
    /// this part and those that are culled concurrently; once used up, blocks of further mixtures
    /// are evaluated.
    abi::KernelStatus run(const PlacedPart& part, int32_t slab, const voxel::SlabMask& mask,
                          bool cull, BlockEvaluator* evaluator, std::atomic<int64_t>* room);

    /// Return the rectangle of blocks that the mask covers.
    int32_t first_x() const { return first_x_; }
    int32_t end_x() const { return first_x_ + blocks_x_; }
    int32_t first_y() const { return first_y_; }
    int32_t end_y() const { return first_y_ + blocks_y_; }
    /// Returns kEvaluate, kNotCovered, or the index of the block's mixture.
    int32_t at(int32_t x, int32_t y) const {
        return blocks_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
    }
    /// Returns a distance that a block to evaluate may take for all of its voxels, as none has to
    /// know its nearest surface point, mm; NaN if some may have to.
    float blind_distance(int32_t x, int32_t y) const {
        return blind_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
    }
    /// Returns the attributes that all voxels of a block have (CubeBounds::Known), which a block with a
    /// blind distance is evaluated with; null: none. Valid until the next slab.
    const nearest::NearestCase* attributes(int32_t x, int32_t y) const {
        return attributes_[static_cast<size_t>((y - first_y_) * blocks_x_ + (x - first_x_))];
    }
    /// Returns what to try on the remaining blocks: parts of them may be uniform, or may not have to
    /// look at the surface.
    const CullTries& tries() const { return tries_; }
    /// Returns the number of blocks to evaluate.
    int64_t blocks_to_evaluate() const;
    const Constant& constant(int32_t index) const { return constants_[index]; }

  private:
    void mark_covered(const voxel::SlabMask& mask);
    bool any_covered(const CullCube& cube, int32_t side) const;
    static bool has_rule(const PlacedPart& part, const Constant& constant);
    abi::KernelStatus add_constant(const PlacedPart& part, const float* weights,
                                   BlockEvaluator* evaluator, std::atomic<int64_t>* room,
                                   int32_t* index);
    /// Bounds the cubes and fills uniform ones; the others are subdivided and replace them.
    abi::KernelStatus fill_uniform_cubes(const PlacedPart& part, int32_t slab, int32_t side,
                                         BoundSource from, BlockEvaluator* evaluator,
                                         std::atomic<int64_t>* room, std::vector<CullCube>* cubes);
    void fill(const CullCube& cube, int32_t side, int32_t constant_index);
    void note_blind(const CubeBounds& bounds, size_t number, int32_t side, BoundSource from,
                    CullCube* cube);
    bool keep_attributes(const nearest::NearestCase** attributes);
    void list_some(const PlacedPart& part, int32_t slab);
    abi::KernelStatus probe_pieces(const PlacedPart& part, int32_t slab, BlockEvaluator* evaluator);

    int32_t first_x_ = 0, first_y_ = 0, blocks_x_ = 0, blocks_y_ = 0;
    std::vector<int32_t> blocks_;
    std::vector<float> blind_;                             ///< [block]
    std::vector<const nearest::NearestCase*> attributes_;  ///< [block]
    /// What attributes_ points to, each once.
    std::vector<std::unique_ptr<const nearest::NearestCase>> kept_attributes_;
    nearest::NearestCase found_;
    std::vector<Constant> constants_;
    std::vector<Vec3i> lowest_;  ///< of the current cubes
    std::vector<CubeBounds::Known> known_;
    CullTries tries_;
};

}  // namespace openfab::volume
