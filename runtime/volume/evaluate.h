// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The volume stage on lists of blocks: nearest queries for the voxels whose path asks for them, the
// volume kernel, normalise. One evaluator per thread.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "abi/stages.h"
#include "runtime/dither/band.h"
#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/print_part.h"
#include "runtime/volume/volume_phases.h"

namespace openfab::slab {

/// A block of the band and the voxels of it that belong to the part.
struct OwnedBlock {
    int32_t block = 0;                           ///< column in the band
    alignas(8) std::array<uint8_t, 64> owned{};  ///< bit z of byte y * 8 + x
};

/// What one thread has counted; added up at the end.
struct EvaluationCounts {
    int64_t evaluated = 0, filled = 0, total = 0;
    int64_t unusable = 0;
    double seconds_nearest = 0, seconds_volume = 0, seconds_normalise = 0, seconds_bounds = 0;
};

class BlockEvaluator {
  public:
    /// Blocks in one call of the volume kernel: enough to spread the call's cost, few enough for
    /// the L2 cache.
    static constexpr int32_t kBatch = 16;

    BlockEvaluator(const openfab_stage_set& set, openfab_isa isa, size_t parts);

    /// Evaluates up to kBatch blocks of block row `row` in group `group` and merges them into the
    /// band; what the fablet prints goes to `prints`. `finer`: pieces that can hold one
    /// composition only ask no queries, which changes nothing else.
    abi::KernelStatus evaluate(const PrintPart& part, int32_t group, const OwnedBlock* blocks,
                               int32_t n, bool finer, RowBand* band, PointPrints* prints);

    /// One composition for a whole block: codes and fractions as the volume kernel's weights would
    /// give them. `weights`: one for each slot; `codes`: 512, `tile`: StageCalls::tile_values().
    abi::KernelStatus constant_block(const PrintPart& part, const float* weights, uint8_t* codes,
                                     uint16_t* tile);

    nearest::Engine::Scratch* scratch(const PrintPart& part);
    /// Queries asked by this thread, over all parts.
    nearest::QueryCounts query_counts() const;

    /// What this thread bounds cubes of the part with.
    CubeBounds::Tools bound_tools(const PrintPart& part) {
        return {part.bounds.any() ? scratch(part) : nullptr, &arguments_, isa_};
    }
    /// What it bounds them in.
    CubeBounds& cube_bounds() { return cube_bounds_; }
    int32_t channels() const { return calls_.channels(); }
    int32_t tile_values() const { return calls_.tile_values(); }
    EvaluationCounts counts;

  private:
    void prepare(const PrintPart& part);
    abi::KernelStatus find_demand(const PrintPart& part, int32_t n);
    abi::KernelStatus settle_pieces(const PrintPart& part, int32_t n);
    abi::KernelStatus find_settled_code(const PrintPart& part, uint8_t* code);
    void fill_settled(const PrintPart& part, int32_t place);
    void prepare_queries(const PrintPart& part, int32_t n);
    void query(const PrintPart& part, int32_t place);
    void clear_inputs(const PrintPart& part, int32_t place);
    abi::KernelStatus run_volume(const PrintPart& part, int32_t n, PointPrints* prints);
    abi::KernelStatus normalise(const PrintPart& part, int32_t n);
    abi::KernelStatus normalise_slice(const PrintPart& part, int32_t n, int32_t z);
    abi::KernelStatus normalise_columns(const PrintPart& part, int32_t n);
    abi::KernelStatus normalise_packed(const PrintPart& part, int32_t n);
    const void* input(const PrintPart& part, const openfab_arg& arg) const;

    StageCalls calls_;
    openfab_isa isa_;
    std::vector<std::unique_ptr<nearest::Engine::Scratch>> scratch_;    ///< by PrintPart::owner
    std::vector<nearest::AttributeReader::Scratch> attribute_scratch_;  ///< by PrintPart::owner
    KernelArguments arguments_;
    VolumePhases phases_;
    nearest::BlockAnswer answer_;
    std::array<int32_t, 3 * kBatch> corners_{};
    std::vector<float> values_, gradients_, distance_,
        weights_;  ///< [component][block][512]; weights [block][slot][512]
    std::vector<uint32_t> flat_;
    std::vector<float*> value_targets_,
        gradient_targets_;  ///< of the block in hand; null where no kernel asks
    std::vector<uint32_t*> flat_targets_;
    std::vector<uint8_t> owned_;
    std::vector<uint8_t> demand_;  ///< of the owned voxels those that ask, in the same order
    CubeBounds cube_bounds_;
    std::vector<Vec3i> blocks_;  ///< lowest voxels
    std::vector<float> piece_weights_;
    std::array<uint32_t, kBatch> settled_{};  ///< of each block a bit a piece
    std::array<std::array<float, CubeBounds::kPieces>, kBatch> settled_distance_{};
    /// Their codes; those that are mixed, or that normalise has to count, are OPENFAB_CODE_MIXED.
    std::array<std::array<uint8_t, CubeBounds::kPieces>, kBatch> settled_code_{};
    std::array<uint8_t, 64 * kBatch> coded_{};  ///< voxels whose code is known, as owned_
    struct KnownCode {
        std::vector<float> weights;
        uint8_t code;
    };
    std::vector<KnownCode> known_codes_;  ///< of the part below
    const PrintPart* known_part_ = nullptr;
    std::vector<int32_t> demanded_;  ///< what the demand kernel says, [block][512]
    std::vector<uint16_t> tiles_;
    std::vector<uint8_t> codes_;
    std::vector<size_t> columns_;  ///< that normalise has to look at: 64 block + column
    /// Blocks made up of such columns, or of the slices of eight blocks side by side.
    std::vector<float> packed_weights_;
    std::vector<uint8_t> packed_owned_, packed_codes_;
    std::vector<uint16_t> packed_tiles_;
    std::array<int32_t, 8 * kBatch> unusable_{};
};

}  // namespace openfab::slab
