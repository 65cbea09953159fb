// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Evaluates the volume stage on lists of blocks: nearest queries for the voxels that need them, and
// the slab kernel on the columns of voxels that are worth it. One evaluator per thread.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "abi/stages.h"
#include "runtime/dither/band.h"
#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/placed_part.h"
#include "runtime/volume/volume_segments.h"

namespace openfab::volume {

/// A block of the band and the voxels of it that belong to the part.
struct OwnedBlock {
    int32_t block = 0;                           ///< column in the band
    alignas(8) std::array<uint8_t, 64> owned{};  ///< bit z of byte y * 8 + x
};

/// Counters of one thread; added up at the end.
struct EvaluationCounts {
    int64_t evaluated = 0, filled = 0, total = 0;
    int64_t unusable = 0;
    double seconds_nearest = 0, seconds_slab = 0, seconds_bounds = 0;
};

/// What a column of equal voxels is made of.
struct ConstantColumn {
    std::array<uint8_t, 8> codes{};
    std::vector<uint16_t> fractions;  ///< 8 a channel
    bool usable = false;              ///< no amount was negative or NaN
};

/// Copies the fractions of one column from channels to the places of their materials.
void place_fractions(const abi::Channels& channels, const uint16_t* from, uint16_t* to);

class BlockEvaluator {
  public:
    /// Blocks in one call of the slab kernel: enough to spread the call's cost, few enough for
    /// the L2 cache.
    static constexpr int32_t kBatch = 16;

    BlockEvaluator(openfab_isa isa, size_t parts);

    /// Evaluates up to kBatch blocks of block row `row` in slab `slab` and merges them into the
    /// band; what the fablet prints goes to `prints`. `try_pieces`: pieces that can hold one
    /// composition only ask no queries, which changes nothing else.
    abi::KernelStatus evaluate(const PlacedPart& part, int32_t slab, const OwnedBlock* blocks,
                               int32_t n, bool try_pieces, dither::RowBand* band, PrintfLog* log);

    /// Computes codes and fractions of voxels of these weights, one for each slot, as the slab
    /// kernel would give them.
    abi::KernelStatus constant_column(const PlacedPart& part, const float* weights,
                                      ConstantColumn* out);

    nearest::Engine::Scratch* scratch(const PlacedPart& part);
    /// Returns the number of queries made by this thread, over all parts.
    nearest::QueryCounts query_counts() const;

    /// Returns this thread's tools for bounding cubes of the part.
    CubeBounds::Tools bound_tools(const PlacedPart& part) {
        return {part.bounds.any() ? scratch(part) : nullptr, &arguments_, isa_};
    }
    /// Returns this thread's bounds of cubes.
    CubeBounds& cube_bounds() { return cube_bounds_; }
    EvaluationCounts counts;

  private:
    void prepare(const PlacedPart& part);
    abi::KernelStatus cull_pieces(const PlacedPart& part, int32_t n);
    abi::KernelStatus find_culled_code(const PlacedPart& part, uint8_t* code);
    void list_columns(int32_t n);
    abi::KernelStatus find_demand(const PlacedPart& part, int32_t n);
    void fill_culled(const PlacedPart& part, int32_t index);
    void prepare_queries(const PlacedPart& part, int32_t n);
    void query(const PlacedPart& part, int32_t index);
    void clear_inputs(const PlacedPart& part, int32_t index);
    abi::KernelStatus run_slab(const PlacedPart& part, int32_t n, int32_t channels,
                               uint16_t* fractions);
    abi::KernelStatus run_segments(const PlacedPart& part, int32_t n, int32_t channels,
                                   uint16_t* fractions, PrintfLog* log);
    void merge(const PlacedPart& part, const OwnedBlock* blocks, int32_t n, int32_t fractions,
               dither::RowBand* band);
    const void* input(const PlacedPart& part, const openfab_arg& arg) const;

    openfab_isa isa_;
    std::vector<std::unique_ptr<nearest::Engine::Scratch>> scratch_;    ///< by PlacedPart::owner
    std::vector<nearest::AttributeReader::Scratch> attribute_scratch_;  ///< by PlacedPart::owner
    KernelArguments arguments_;
    VolumeSegments segments_;
    nearest::BlockAnswer answer_;
    std::array<int32_t, 3 * kBatch> corners_{};
    std::vector<float> values_, gradients_, distance_;  ///< [component][block][512]
    std::vector<uint32_t> flat_;
    std::vector<float*> value_targets_,
        gradient_targets_;  ///< of the current block; null where no kernel reads it
    std::vector<uint32_t*> flat_targets_;
    std::array<uint8_t, 64 * kBatch> owned_{};
    std::array<uint8_t, 64 * kBatch> demand_{};  ///< owned voxels that query, in the same order
    CubeBounds cube_bounds_;
    std::vector<Vec3i> blocks_;  ///< lowest voxels
    std::vector<float> piece_weights_;
    std::array<uint32_t, kBatch> culled_pieces_{};  ///< per block, a bit per piece
    std::array<std::array<float, CubeBounds::kPieces>, kBatch> culled_distance_{};
    /// Codes of culled pieces; OPENFAB_CODE_MIXED where mixed or where the slab kernel has to count.
    std::array<std::array<uint8_t, CubeBounds::kPieces>, kBatch> culled_code_{};
    std::array<uint8_t, 64 * kBatch>
        known_code_mask_{};  ///< voxels whose code is known, laid out like owned_
    struct KnownCode {
        std::vector<float> weights;
        uint8_t code;
    };
    std::vector<KnownCode> known_codes_;  ///< of known_part_
    const PlacedPart* known_part_ = nullptr;
    ConstantColumn constant_;
    /// Columns to evaluate, 64 block + column; those of block i begin at first_column_[i].
    std::vector<int32_t> columns_;
    std::array<size_t, kBatch + 1> first_column_{};
    std::vector<int32_t> demanded_;    ///< output of the demand kernel, 8 a column
    std::vector<float> weights_;       ///< of a stage of segments, [slot][block][512]
    std::vector<uint16_t> fractions_;  ///< [column][channel][8]; of the slab kernel those channels
                                       ///< alone that no material has, [channel][column][8]
    std::vector<uint16_t> unusable_;
    std::vector<uint8_t> codes_;
};

}  // namespace openfab::volume
