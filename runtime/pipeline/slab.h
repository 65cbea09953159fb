// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs one slab (8 slices) from coverage to packed planes. Rows of blocks are evaluated in
// parallel, ahead of the dither, which processes them in order; so one slab can use several
// threads, and the first slice is ready early.

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/pool.h"
#include "runtime/dither/band.h"
#include "runtime/dither/support_fill.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/overlaps.h"
#include "runtime/process/nozzles.h"
#include "runtime/volume/cull.h"
#include "runtime/volume/evaluate.h"
#include "runtime/volume/placed_part.h"

namespace openfab::pipeline {

/// Reasons to end a print early; checked for each row of blocks.
struct StopFlags {
    const std::atomic<bool>& interrupt;  ///< set by the caller
    std::atomic<bool> failed{false};
    bool requested() const {
        return failed.load(std::memory_order_relaxed) || interrupt.load(std::memory_order_relaxed);
    }
};

/// Returns how many of a print's materials fablets can name: support, if it is the last and not one of
/// theirs, is added after the stages.
int32_t model_materials(const std::vector<part::Part>& parts, int32_t materials,
                        int32_t support_code);

/// Settings that are the same for all slabs.
struct SlabSetup {
    const std::vector<std::unique_ptr<volume::PlacedPart>>* parts = nullptr;  ///< in build order
    std::vector<int32_t>
        order;  ///< of parts: higher priority first, ties go to the later in the build list
    int32_t channels = 0;  ///< of fractions, see dither::fraction_channels
    openfab_isa isa = OPENFAB_ISA_AVX2;
    dither::DitherRule dither = dither::kDefaultDither;
    uint64_t seed = 0;
    Vec3i size;  ///< grid size, voxels
    bool culling = true;
    int32_t rows_in_flight = 2;  ///< rows of blocks of one slab evaluated ahead
    int32_t bits = 4;            ///< per packed voxel
    dither::SupportFill support;
    int32_t materials = 0;              ///< of the model
    FractionSink* fractions = nullptr;  ///< may be null
    /// Whether mixtures are kept beside what the fablets' rules make of them, for `fractions`.
    bool separate_mixtures = false;
};

/// Stage times, seconds summed over threads.
struct SlabTimes {
    double coverage = 0, dither = 0, support = 0, pack = 0;
};

/// Memory of one slab in flight, reused by later slabs.
class SlabRun {
  public:
    explicit SlabRun(const SlabSetup& setup);

    /// Memory limit for mixtures that fill whole blocks of one slab, over all its parts.
    static constexpr int64_t kUniformBlockBytes = 8 << 20;

    /// Coverage and culling of slices [8 slab, 8 slab + 8). `interrupt`, if not null, stops them, and what
    /// is run of the slab afterwards, between batches of blocks.
    abi::KernelStatus begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                            const std::atomic<bool>* interrupt);
    /// Sets the nozzles that what is printed from now on has; null: all are alive.
    void set_nozzles(std::shared_ptr<const process::Nozzles> nozzles);
    /// Returns the number of blocks that culling left: the cost of printing any slices of the slab.
    int64_t blocks_to_evaluate() const { return blocks_to_evaluate_; }
    /// Prints some slices of the slab that was begun into planes(), those of bit z & 7 in `slices`;
    /// the planes of the others are undefined.
    abi::KernelStatus run(uint8_t slices, Pool<volume::BlockEvaluator>* evaluators,
                          const StopFlags& stop);
    /// Prints them piece by piece, as TrySlab says; `pieces` becomes the number of those begun. The
    /// planes have the rows of these alone.
    abi::KernelStatus try_rows(uint8_t slices, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop, int32_t* pieces);

    const dither::SlabPlanes& planes() const { return planes_; }
    /// Returns the printf lines of the slab's voxels, which the caller may move from.
    segments::PrintfLog& log() { return log_; }
    /// Returns the overlaps of all slabs so far.
    const Overlaps& overlaps() const { return overlaps_; }
    SlabTimes times;

  private:
    struct ActivePart {
        const volume::PlacedPart* part;
        voxel::SlabMask mask;
        std::vector<solid::FilledMask> filled;  ///< of a piece, what other materials have of it
        volume::PartCull cull;
        double seconds_coverage = 0;

        bool covers() const { return mask.width > 0 && mask.height > 0; }
    };
    /// Scratch of one row in flight.
    struct Row {
        dither::RowBand band;
        dither::RowBand mixtures;  ///< see SlabSetup::separate_mixtures
        bool many = false;         ///< more than one part in the row: claims are tracked
        RowClaims claims;
        Overlaps overlaps;
        std::vector<volume::OwnedBlock> pending;  ///< blocks of one part to evaluate
        segments::PrintfLog log;
    };

    abi::KernelStatus begin_part(ActivePart* active, volume::BlockEvaluator* evaluator,
                                 std::atomic<int64_t>* room) const;
    volume::BlockEvaluator* take_evaluator(Pool<volume::BlockEvaluator>* evaluators) const;
    abi::KernelStatus evaluate_row(int32_t row, Row* scratch,
                                   volume::BlockEvaluator* evaluator) const;
    uint64_t fill_connectors(const ActivePart& active, Row* scratch,
                             volume::OwnedBlock* block) const;
    abi::KernelStatus evaluate_part(const ActivePart& active, Row* scratch,
                                    volume::BlockEvaluator* evaluator) const;
    bool prepare(uint8_t slices);
    Vec2<int32_t> rows_in_use() const;
    abi::KernelStatus run_rows(int32_t first, int32_t end, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop);

    const SlabSetup& setup_;
    const std::atomic<bool>* interrupt_ = nullptr;
    int32_t slab_ = 0;
    uint64_t slices_ = 0;  ///< bits of the slices to print, repeated in each byte (column)
    int64_t blocks_to_evaluate_ = 0;
    /// Parts in this slab; those that are also in the next slab are reused.
    std::vector<std::unique_ptr<ActivePart>> active_;
    Pool<Row> rows_;
    dither::SlabPlanes planes_;
    segments::PrintfLog log_;
    Overlaps overlaps_;
    std::shared_ptr<const process::Nozzles> nozzles_;
    dither::SlabDither dither_;
};

}  // namespace openfab::pipeline
