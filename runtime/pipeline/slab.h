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
#include "runtime/pipeline/overlaps.h"
#include "runtime/pipeline/slab_parts.h"
#include "runtime/process/bleed/bleed.h"
#include "runtime/process/nozzles/nozzles.h"
#include "runtime/volume/evaluate.h"

namespace openfab::pipeline {

/// Reasons to end a print early; checked for each row of blocks.
struct StopFlags {
    const std::atomic<bool>& interrupt;  ///< set by the caller
    std::atomic<bool> failed{false};
    bool requested() const {
        return failed.load(std::memory_order_relaxed) || interrupt.load(std::memory_order_relaxed);
    }
};

/// Stage times, seconds summed over threads.
struct SlabTimes {
    double coverage = 0, dither = 0, support = 0, pack = 0;
};

/// Memory of one slab in flight, reused by later slabs.
class SlabRun {
  public:
    explicit SlabRun(const SlabSetup& setup);

    /// Coverage and culling of slices [8 slab, 8 slab + 8). `interrupt`, if not null, stops them, and what
    /// is run of the slab afterwards, between batches of blocks.
    abi::KernelStatus begin(int32_t slab, Pool<volume::BlockEvaluator>* evaluators,
                            const std::atomic<bool>* interrupt);
    /// Sets the nozzles that what is printed from now on has; null: all are alive.
    void set_nozzles(std::shared_ptr<const process::Nozzles> nozzles);
    /// Returns the number of blocks that culling left: the cost of printing any slices of the slab.
    int64_t blocks_to_evaluate() const { return own_.blocks_to_evaluate(); }
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
    /// Returns, by part, whether any slab so far holds a voxel of it.
    const std::vector<bool>& covered() const { return own_.covered(); }
    /// Returns the overlaps of all slabs so far.
    const Overlaps& overlaps() const { return overlaps_; }
    /// Returns how many voxels of all slabs so far were mixtures.
    int64_t mixed() const { return mixed_; }
    SlabTimes times;

  private:
    class Around;

    bool prepare(uint8_t slices);
    Vec2<int32_t> rows_to_run() const;
    void take_notes(SlabRow* row);
    void finish_band(dither::RowBand* band, dither::RowBand* mixtures);
    abi::KernelStatus run_rows(int32_t first, int32_t end, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop);
    abi::KernelStatus run_rows_with_bleed(int32_t first, int32_t end,
                                          Pool<volume::BlockEvaluator>* evaluators,
                                          const StopFlags& stop);
    abi::KernelStatus evaluate_around(int32_t row, Pool<volume::BlockEvaluator>* evaluators,
                                      Around* around);

    const SlabSetup& setup_;
    SlabParts own_;
    /// Slabs below and above whose voxels bleed into this one, from the lowest on, without it.
    std::vector<std::unique_ptr<SlabParts>> near_;
    uint8_t slices_ = 0;  ///< bits of the slices to print
    Pool<SlabRow> rows_;
    Pool<process::BleedScratch> bleeds_;
    dither::SlabPlanes planes_;
    segments::PrintfLog log_;
    Overlaps overlaps_;
    std::atomic<int64_t> mixed_ = 0;
    std::shared_ptr<const process::Nozzles> nozzles_;
    dither::SlabDither dither_;
};

}  // namespace openfab::pipeline
