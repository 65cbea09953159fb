// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Evaluates the volume stage on lists of blocks: chooses the columns of voxels that are worth it,
// calls the slab kernel, merges what it gives into a band. One evaluator per thread.

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "abi/stages.h"
#include "runtime/dither/band.h"
#include "runtime/volume/cube_bounds.h"
#include "runtime/volume/kernel_arguments.h"
#include "runtime/volume/nearest_stage.h"
#include "runtime/volume/piece_cull.h"
#include "runtime/volume/placed_part.h"
#include "runtime/volume/volume_segments.h"

namespace openfab::volume {

/// A block of the band and the voxels of it that belong to the part.
struct OwnedBlock {
    int32_t block = 0;                                               ///< column in the band
    alignas(8) std::array<uint8_t, 64> owned{};                      ///< bit z of byte y * 8 + x
    float blind_distance = std::numeric_limits<float>::quiet_NaN();  ///< PartCull::blind_distance
    const nearest::NearestCase* attributes = nullptr;                ///< PartCull::attributes
};

/// Voxels of one part, where they were evaluated or filled.
struct PartVoxels {
    int64_t own = 0;       ///< that it covers, and no part of a higher priority
    int64_t empty = 0;     ///< of them: no material has an amount above 0 there
    int64_t unusable = 0;  ///< amounts that are negative or NaN
};

/// Counters of one thread; added up at the end.
struct EvaluationCounts {
    explicit EvaluationCounts(size_t parts) : by_part(parts) {}

    std::vector<PartVoxels> by_part;  ///< by PlacedPart::index
    int64_t evaluated = 0, filled = 0, total = 0;
    int64_t known_blocks = 0;  ///< evaluated blocks of which culling knew everything
    int64_t columns = 0;       ///< listed for the slab kernel
    /// Of the arrays that nearest and the slab kernel filled.
    int64_t nearest_bytes = 0, slab_bytes = 0;
    double seconds_slab = 0;  ///< nearest queries included
    double seconds_bounds = 0;
};

/// Derivatives of the fractions in a row of blocks, of a print that is asked for them.
struct RowRates {
    int32_t width = 0;          ///< voxels
    int32_t materials = 0;      ///< of the model
    int32_t columns = 0;        ///< uniforms' numbers
    std::vector<float> values;  ///< [y 8][x][column][material][z 8]
    bool any = false;           ///< whether there is more than zeros

    size_t per_voxel() const {
        return static_cast<size_t>(materials) * static_cast<size_t>(columns);
    }
    /// Makes all 0.
    void reset(int32_t width_vox, int32_t material_count, int32_t column_count);
    /// Returns the 8 values of a number, column * materials + material, in a column of voxels.
    float* at(int32_t x, int32_t y, int32_t number) { return &values[index(x, y, number)]; }
    const float* at(int32_t x, int32_t y, int32_t number) const {
        return &values[index(x, y, number)];
    }

  private:
    size_t index(int32_t x, int32_t y, int32_t number) const {
        const auto column =
            static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
        return (column * per_voxel() + static_cast<size_t>(number)) * 8;
    }
};

/// Copies the fractions of one column from channels to the places of their materials.
void place_fractions(const abi::Channels& channels, const uint16_t* from, uint16_t* to);

class BlockEvaluator {
  public:
    /// Blocks in one call of the slab kernel.
    static constexpr int32_t kBatch = 16;

    BlockEvaluator(openfab_isa isa, size_t parts);

    /// Evaluates up to kBatch blocks of block row `row` in slab `slab` and merges them into the
    /// band, and into `mixtures`, if any, before a rule of the fablet's own; printf output goes to
    /// `log`. `tries`: what is uniform, or need not look at the surface, makes no queries, which
    /// changes nothing else.
    abi::KernelStatus evaluate(const PlacedPart& part, int32_t slab, const OwnedBlock* blocks,
                               int32_t n, const CullTries& tries, dither::RowBand* band,
                               dither::RowBand* mixtures, segments::PrintfLog* log);

    /// Returns the number of queries made by this evaluator, over all parts.
    nearest::QueryCounts query_counts() const;
    double seconds_nearest() const { return nearest_.seconds(); }

    /// Returns this thread's tools for bounding cubes of the part.
    CubeBounds::Tools bound_tools(const PlacedPart& part) {
        return {part.bounds.any() ? nearest_.scratch(part) : nullptr, &arguments_, isa_};
    }
    /// Returns this thread's bounds of cubes.
    CubeBounds& cube_bounds() { return cube_bounds_; }
    openfab_isa isa() const { return isa_; }
    EvaluationCounts counts;
    /// Once set, blocks whose segments loop or query are given up, stopped; null: never.
    const std::atomic<bool>* stop = nullptr;
    /// Takes the derivatives of the next batch; `rate_columns` says which column each direction of the part is, -1 none.
    /// Null: nobody wants them.
    RowRates* rates = nullptr;
    std::span<const int32_t> rate_columns;
    bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }

  private:
    void take_blocks(const PlacedPart& part, int32_t slab, int32_t row, const OwnedBlock* blocks,
                     int32_t n);
    void list_columns(int32_t n);
    /// Calls the slab kernel for columns of `count` blocks from `first` on. `fractions`: `channels` *
    /// 8 values for each column in columns_; null: nobody wants them.
    abi::KernelStatus run_slab(const PlacedPart& part, int32_t first, int32_t count,
                               std::span<const int32_t> columns, int32_t channels,
                               uint16_t* fractions);
    abi::KernelStatus run_packed_slab(const PlacedPart& part, int32_t first, size_t column,
                                      size_t count, int32_t channels, uint16_t* fractions);
    /// Does the same with what segments give, which it runs before.
    abi::KernelStatus run_segments(const PlacedPart& part, const OwnedBlock* blocks, int32_t n,
                                   int32_t channels, uint16_t* fractions, segments::PrintfLog* log);
    abi::KernelStatus ask_for_segments(const PlacedPart& part, int32_t n);
    /// Normalises amounts that segments have written to states, as run_slab otherwise does.
    abi::KernelStatus normalise_states(const PlacedPart& part, int32_t first, int32_t channels,
                                       uint16_t* fractions);
    void take_rates(const PlacedPart& part, int32_t first, int32_t count, const OwnedBlock* blocks);
    const float* field(const PlacedPart& part, const openfab_arg& arg, int32_t first) const;
    void count_columns(const PlacedPart& part);
    /// `codes` of the listed columns, whose fractions begin at the band's number `fractions`.
    void merge(const PlacedPart& part, const OwnedBlock* blocks, int32_t n, const uint8_t* codes,
               int32_t fractions, dither::RowBand* band) const;
    void count_unusable(int32_t n, PartVoxels* voxels) const;
    /// Counts the owned voxels of which the kernel, or culling, knows that they are empty.
    int64_t count_empty(const PlacedPart& part, int32_t n) const;

    openfab_isa isa_;
    KernelArguments arguments_;
    CubeBounds cube_bounds_;
    PieceCull piece_cull_;
    NearestStage nearest_;
    VolumeSegments segments_;
    std::array<int32_t, 3 * kBatch> corners_{};
    std::vector<Vec3i> blocks_;          ///< lowest voxels
    std::array<float, kBatch> blind_{};  ///< distances of those that need none
    std::array<const nearest::NearestCase*, kBatch> attributes_{};  ///< known ones
    std::array<uint8_t, 64 * kBatch> owned_{};
    std::array<CulledBlock, kBatch> culled_{};
    bool culls_ = false;  ///< whether culled_ is of the current blocks
    /// Columns to evaluate, 64 block + column, and the last as often as the kernel wants; those of
    /// block i begin at first_column_[i].
    std::vector<int32_t> columns_;
    std::array<size_t, kBatch + 1> first_column_{};
    std::vector<uint8_t> codes_;
    std::vector<uint8_t> choices_;  ///< of a fablet with a dither rule
    std::vector<uint16_t> unusable_;
    /// Of amounts in states fractions, [column][channel][8]; of the slab kernel those that nobody
    /// wants, [channel][8], one column over another.
    std::vector<uint16_t> fractions_;
    std::vector<uint16_t> packed_;  ///< of a slab kernel with many outputs, [column][output][8]
    /// Of a stage of segments.
    std::vector<int32_t> all_columns_;
    std::vector<int32_t> listed_;  ///< of the blocks that they run on at once, from their first on
    std::vector<uint8_t> demand_;  ///< 8 a column
    std::vector<float> fields_;    ///< [field][block][512]
};

}  // namespace openfab::volume
