// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Evaluates the volume stage on lists of blocks: nearest queries for the voxels that need them, the
// volume kernel, normalise. One evaluator per thread.

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
    double seconds_nearest = 0, seconds_volume = 0, seconds_normalise = 0, seconds_bounds = 0;
};

class BlockEvaluator {
  public:
    /// Blocks in one call of the volume kernel: enough to spread the call's cost, few enough for
    /// the L2 cache.
    static constexpr int32_t kBatch = 16;

    BlockEvaluator(const openfab_stage_set& set, openfab_isa isa, size_t parts);

    /// Evaluates up to kBatch blocks of block row `row` in slab `slab` and merges them into the
    /// band; printf output goes to `prints`. `finer`: uniform pieces make no queries, which changes
    /// nothing else.
    abi::KernelStatus evaluate(const PlacedPart& part, int32_t slab, const OwnedBlock* blocks,
                               int32_t n, bool try_pieces, dither::RowBand* band, PrintfLog* log);

    /// Computes codes and fractions of a block of uniform weights, as the volume kernel's would
    /// give them. `weights`: one for each slot; `codes`: 512, `tile`: StageCalls::tile_values().
    abi::KernelStatus constant_block(const PlacedPart& part, const float* weights, uint8_t* codes,
                                     uint16_t* tile);

    nearest::Engine::Scratch* scratch(const PlacedPart& part);
    /// Returns the number of queries made by this thread, over all parts.
    nearest::QueryCounts query_counts() const;

    /// Returns this thread's tools for bounding cubes of the part.
    CubeBounds::Tools bound_tools(const PlacedPart& part) {
        return {part.bounds.any() ? scratch(part) : nullptr, &arguments_, isa_};
    }
    /// Returns this thread's bounds of cubes.
    CubeBounds& cube_bounds() { return cube_bounds_; }
    int32_t channels() const { return calls_.channels(); }
    int32_t tile_values() const { return calls_.tile_values(); }
    EvaluationCounts counts;

  private:
    void prepare(const PlacedPart& part);
    abi::KernelStatus find_demand(const PlacedPart& part, int32_t n);
    abi::KernelStatus cull_pieces(const PlacedPart& part, int32_t n);
    abi::KernelStatus find_culled_code(const PlacedPart& part, uint8_t* code);
    void fill_culled(const PlacedPart& part, int32_t index);
    void prepare_queries(const PlacedPart& part, int32_t n);
    void query(const PlacedPart& part, int32_t index);
    void clear_inputs(const PlacedPart& part, int32_t index);
    abi::KernelStatus run_volume(const PlacedPart& part, int32_t n, PrintfLog* log);
    abi::KernelStatus normalise(const PlacedPart& part, int32_t n);
    abi::KernelStatus normalise_slice(const PlacedPart& part, int32_t n, int32_t z);
    abi::KernelStatus normalise_columns(const PlacedPart& part, int32_t n);
    abi::KernelStatus normalise_packed(const PlacedPart& part, int32_t n);
    const void* input(const PlacedPart& part, const openfab_arg& arg) const;

    abi::StageCalls calls_;
    openfab_isa isa_;
    std::vector<std::unique_ptr<nearest::Engine::Scratch>> scratch_;    ///< by PlacedPart::owner
    std::vector<nearest::AttributeReader::Scratch> attribute_scratch_;  ///< by PlacedPart::owner
    KernelArguments arguments_;
    VolumeSegments segments_;
    nearest::BlockAnswer answer_;
    std::array<int32_t, 3 * kBatch> corners_{};
    std::vector<float> values_, gradients_, distance_,
        weights_;  ///< [component][block][512]; weights [block][slot][512]
    std::vector<uint32_t> flat_;
    std::vector<float*> value_targets_,
        gradient_targets_;  ///< of the current block; null where no kernel reads it
    std::vector<uint32_t*> flat_targets_;
    std::vector<uint8_t> owned_;
    std::vector<uint8_t> demand_;  ///< owned voxels that query, in the same order
    CubeBounds cube_bounds_;
    std::vector<Vec3i> blocks_;  ///< lowest voxels
    std::vector<float> piece_weights_;
    std::array<uint32_t, kBatch> culled_pieces_{};  ///< per block, a bit per piece
    std::array<std::array<float, CubeBounds::kPieces>, kBatch> culled_distance_{};
    /// Codes of culled pieces; OPENFAB_CODE_MIXED where mixed or where normalise has to count.
    std::array<std::array<uint8_t, CubeBounds::kPieces>, kBatch> culled_code_{};
    std::array<uint8_t, 64 * kBatch>
        known_code_mask_{};  ///< voxels whose code is known, laid out like owned_
    struct KnownCode {
        std::vector<float> weights;
        uint8_t code;
    };
    std::vector<KnownCode> known_codes_;  ///< of known_part_
    const PlacedPart* known_part_ = nullptr;
    std::vector<int32_t> demanded_;  ///< output of the demand kernel, [block][512]
    std::vector<uint16_t> tiles_;
    std::vector<uint8_t> codes_;
    std::vector<size_t> columns_;  ///< columns to normalise: 64 block + column
    /// Blocks packed from such columns, or from one slice each of eight blocks.
    std::vector<float> packed_weights_;
    std::vector<uint8_t> packed_owned_, packed_codes_;
    std::vector<uint16_t> packed_tiles_;
    std::array<int32_t, 8 * kBatch> unusable_{};
};

}  // namespace openfab::volume
