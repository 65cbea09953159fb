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
#include "runtime/process/effect.h"
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
    /// Sets the effects on single voxels of what is printed from now on.
    void set_effects(process::SliceEffects effects);
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
    struct Task;

    bool prepare(uint8_t slices);
    Vec2<int32_t> rows_to_run() const;
    Vec3i reach_blocks(size_t first_spread) const;
    void take_log(SlabRow* row);
    void finish_row(SlabRow* row);
    abi::KernelStatus evaluate_around(int32_t row, Pool<volume::BlockEvaluator>* evaluators,
                                      Around* around);
    std::shared_ptr<Around> spread(size_t number, const Task& task);
    abi::KernelStatus run_rows(int32_t first, int32_t end, Pool<volume::BlockEvaluator>* evaluators,
                               const StopFlags& stop);

    const SlabSetup& setup_;
    SlabParts own_;
    /// Slabs below and above within reach of effects on neighbours, from the lowest on, without it.
    std::vector<std::unique_ptr<SlabParts>> near_;
    uint8_t slices_ = 0;  ///< bits of the slices to print
    Pool<SlabRow> rows_;
    dither::SlabPlanes planes_;
    segments::PrintfLog log_;
    Overlaps overlaps_;
    std::atomic<int64_t> mixed_ = 0;
    process::SliceEffects effects_;
    dither::SlabDither dither_;
};

}  // namespace openfab::pipeline
