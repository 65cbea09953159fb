// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print job: parts on a grid, run slab by slab (8 slices), bottom up, into a sink, under a memory
// budget.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "runtime/pipeline/print_input.h"
#include "runtime/pipeline/print_options.h"
#include "runtime/pipeline/print_statistics.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/pipeline/time_sample.h"

namespace openfab::pipeline {

/// What it took to print some slabs.
struct SlabsRun {
    double begin = 0, end = 0;     ///< when (seconds_now)
    double processor_seconds = 0;  ///< of the whole process meanwhile
    uint64_t hash = 0;             ///< of their slices
};

class PrintJob {
  public:
    /// Sets up surfaces, displacement bounds, query trees and the grid. Fails where the budget is
    /// too small and names the smallest sufficient one.
    static Result<std::unique_ptr<PrintJob>> create(PrintInput input, PrintOptions options);
    virtual ~PrintJob() = default;

    virtual const pipeline::PrintInfo& info() const = 0;
    virtual PrintEstimate estimate() const = 0;
    /// Returns warnings that set-up found, such as of parts that take long. The statistics have
    /// them, too.
    virtual const std::vector<std::string>& warnings() const = 0;
    /// Returns how large the first parts are, in voxels: what to say where none has any material.
    virtual std::string part_sizes() const = 0;
    /// Estimates the time of the print, from the start of the process, from a few slabs, which it
    /// prints for up to that many seconds after the coverage of the first, which may take three. The
    /// sink, which may be null, is begun and takes slices as if they followed each other. Once, and
    /// not after run.
    virtual Result<TimeSample> sample_time(double seconds, pipeline::SliceSink* sink,
                                           const std::atomic<bool>& interrupt) = 0;
    /// Runs to the end, or until `interrupt` is set or the sink fails; slices that were written
    /// stay. The statistics are valid in every case; the error says why it ended early. Calls
    /// sink.begin, resume, encode, commit and finish.
    virtual Result<void> run(pipeline::SliceSink& sink,
                             const std::function<void(const ProgressEvent&)>& progress,
                             const std::atomic<bool>& interrupt, PrintStatistics* statistics) = 0;
    /// Returns the number of threads that it uses.
    virtual int32_t threads() const = 0;
    /// Returns the slabs of the print: [x, y).
    virtual Vec2<int32_t> slabs() const = 0;
    /// Prints some of them, rising, as `run` prints a slab that is not the first. The sink takes
    /// their slices as if there were no others between: those of neighbours have their own numbers. So do
    /// the options' fractions, with the numbers of the print.
    /// May be repeated, also after one that its `interrupt` ended early, and whether or not the
    /// options' own is set by then; not after run. `statistics` may be null; its times and counters of work sum
    /// up over repetitions, what it says of voxels and slices is of these slabs.
    virtual Result<SlabsRun> run_slabs(std::span<const int32_t> slabs, pipeline::SliceSink& sink,
                                       const std::atomic<bool>& interrupt,
                                       PrintStatistics* statistics) = 0;
    /// Gives a part, in build order, other values of its uniforms, as many as it has, for run_slabs from now on.
    /// Returns whether it could: not where a surface or a geometry may depend on them, which are set up already.
    /// The provenance of `info` stays that of the first values.
    virtual bool set_uniforms(size_t part, std::span<const uint32_t> values) = 0;
};

}  // namespace openfab::pipeline
