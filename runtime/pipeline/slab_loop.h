// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints slabs of a print that is set up: several in flight, committed in order.

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>

#include "abi/kernel_status.h"
#include "base/pool.h"
#include "runtime/pipeline/print_setup.h"
#include "runtime/pipeline/slab.h"
#include "runtime/pipeline/slice_committer.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/volume/evaluate.h"

namespace openfab::pipeline {

/// Where slabs go, and what ends them early.
struct SlabTarget {
    const SliceSink& sink;  ///< encodes
    SliceCommitter* committer;
    const std::atomic<bool>* interrupt;  ///< also ends coverage and batches of blocks; may be null
};

class SlabLoop {
  public:
    explicit SlabLoop(const PrintSetup& setup) : setup_(setup) {}

    /// Prints all slabs that the committer does not have. The first one runs alone: all threads work on
    /// its rows, and the first slices are early.
    void print_rest(const SlabTarget& target);
    /// Prints what `next` gives, up to a negative slab.
    void print_all(const std::function<SlabSlices()>& next, const SlabTarget& target);
    /// Encodes slices [finished->first, finished->end) of a slab that was run.
    void encode(const SliceSink& sink, const SlabRun& run, int32_t shift, FinishedSlices* finished);

    /// Memory of slabs and evaluators, for whoever runs a slab in another way, and their counters.
    Pool<SlabRun>& runs() { return runs_; }
    Pool<volume::BlockEvaluator>& evaluators() { return evaluators_; }
    const Pool<SlabRun>& runs() const { return runs_; }
    const Pool<volume::BlockEvaluator>& evaluators() const { return evaluators_; }
    SlabRun* take_run();
    double seconds_encode() const { return seconds_encode_; }
    double seconds_count() const { return seconds_count_; }

  private:
    SlabSlices with_effects(SlabSlices slices) const;
    void begin_period() const;
    void print_first(int32_t slab, const SlabTarget& target);
    FinishedSlices print_slab(const SlabSlices& slab, const SlabTarget& target);
    FinishedSlices print_slices(const SlabSlices& slices, abi::KernelStatus begun, SlabRun* run,
                                const SlabTarget& target);
    Result<void> outcome() const;

    const PrintSetup& setup_;
    Pool<SlabRun> runs_;
    Pool<volume::BlockEvaluator> evaluators_;
    std::mutex encode_mutex_;
    double seconds_encode_ = 0, seconds_count_ = 0;
};

/// Returns the bits of slices [first, end) of one slab, as SlabRun::run takes them.
inline uint8_t bits_of_slices(int32_t first, int32_t end) {
    return static_cast<uint8_t>(((1 << (end - first)) - 1) << (first & 7));
}

}  // namespace openfab::pipeline
