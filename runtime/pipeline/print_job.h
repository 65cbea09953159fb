// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print job: parts on a grid, run slab by slab (8 slices), bottom up, into a sink, under a memory
// budget.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "base/units.h"
#include "runtime/dither/dither_rule.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/pipeline/time_sample.h"

namespace openfab::pipeline {

struct PrintOptions {
    int64_t memory_bytes = kDefaultMemoryBytes;  ///< without the reserved part
    int64_t reserved_bytes = 0;                  ///< part of the user's budget, for previews
    int32_t threads = 0;                         ///< 0: all cores
    std::string dither = dither::kOwnDitherName;
    uint64_t seed = 0;
    std::optional<Vec2<double>> z_range_mm;  ///< --z, above the grid's lowest corner
    std::optional<Vec2<int32_t>> slices;     ///< --slices A:B, B exclusive
    bool culling = true;  ///< off: every covered block is evaluated voxel by voxel
    bool infer_identity = true;
    int32_t slabs_in_flight =
        0;  ///< 0: from threads and memory; the output never depends on it, which tests check
    /// Number of blocks of the first slab; if culling leaves more, its first slice is printed
    /// alone, then the others, which evaluates the blocks twice: about a second once, but the first
    /// slice is ready seconds earlier. Tests vary it, too.
    int64_t most_blocks_at_first = 40'000;
    openfab_isa isa = OPENFAB_ISA_AVX512;  ///< the best to use
    /// Once set, set-up and run end soon; set-up fails. It must outlive the print.
    const std::atomic<bool>* interrupt = nullptr;
    bool interrupted() const {
        return interrupt != nullptr && interrupt->load(std::memory_order_relaxed);
    }
    /// The age of the process when this print began, if it is not the process's only one: times in
    /// events and statistics count from it.
    double began_seconds = 0;
    FractionSink* fractions =
        nullptr;  ///< takes what the dither takes, too; must outlive the print
    int64_t sink_bytes_per_column = 0;  ///< memory of the sink for each voxel of a slice
    /// Receives the lines of printf, in an order that does not depend on threads; called from one
    /// thread.
    std::function<void(const std::string& line)> print_line;
};

struct PrintInput {
    std::vector<part::Part> parts;                   ///< in build order
    std::vector<pipeline::SliceMaterial> materials;  ///< code 1 is materials[0]
    /// The material code of support below parts; 0: no support.
    int32_t support_code = 0;
    Vec3d pitch_mm;
    std::optional<Box3d> crop_mm;  ///< a box that the grid covers, too
    /// In place of the parts' own box: the grid is this one, rounded out to whole voxels, and what
    /// reaches beyond is cut off.
    std::optional<Box3d> window_mm;
    std::string printer;
    std::string title;
    std::vector<std::string> warnings;  ///< copied to the statistics
};

/// The figures of `--estimate`, known after set-up and before the first slice.
struct PrintEstimate {
    Vec3i size;
    int64_t voxels_total = 0;
    int64_t memory_bytes = 0;
    double seconds = 0;  ///< at a typical rate
};

/// The figures that `--stats` writes.
struct PrintStatistics {
    int64_t voxels_total = 0;  ///< tight box of printed voxels
    int64_t voxels_solid = 0;  ///< without support
    int64_t voxels_support = 0;
    std::vector<int64_t> voxels_by_code;
    Box3i tight;
    int32_t slices = 0;
    double seconds_total = 0;  ///< from the start of the process, or PrintOptions::began_seconds
    double seconds_first_slice = 0;                                ///< likewise
    std::vector<std::pair<std::string, double>> seconds_by_stage;  ///< summed over threads
    int64_t peak_rss_bytes = 0;
    int32_t threads = 0;
    int64_t blocks_total = 0, blocks_filled = 0, blocks_evaluated = 0;
    int64_t queries_asked = 0, queries_skipped = 0;
    int64_t columns_evaluated = 0;  ///< of 8 voxels, listed for the slab kernel
    /// Of the arrays between nearest, slab kernel and dither.
    int64_t nearest_bytes = 0, slab_bytes = 0;
    int64_t sink_bytes = 0;  ///< of encoded slices
    int64_t cache_hits = 0, cache_misses = 0, cache_evictions = 0, cache_peak_bytes = 0;
    int64_t weights_not_usable = 0;  ///< negative or NaN amounts, replaced by 0
    int64_t displacements_not_finite = 0, displacements_cut = 0;
    uint64_t hash = 0;  ///< of all slices' packed rows
    bool complete = false;
    double layer_time_s = 0;  ///< of the printer; 0: unknown
    /// Slices that an earlier print had written; the times and the other counters are this print's
    /// alone.
    int32_t slices_resumed = 0;
    int64_t voxels_solid_resumed = 0;   ///< without support
    std::vector<std::string> warnings;  ///< those of the input, and `late_warnings`
    /// What only printing shows: parts of equal priority that overlap, displacements that were changed.
    std::vector<std::string> late_warnings;
};

/// Returns the fraction of voxels_total that this print has made itself, by slices.
inline int64_t voxels_printed(const PrintStatistics& s) {
    return s.slices_resumed == 0 ? s.voxels_total
                                 : s.voxels_total / s.slices * (s.slices - s.slices_resumed);
}

/// Progress after each committed slice; reported from one thread.
struct ProgressEvent {
    int32_t slices_done = 0, slices_total = 0;
    int64_t voxels_done = 0, voxels_total = 0;
    double seconds = 0;
};

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
    /// their slices as if there were no others between: those of neighbours have their own numbers.
    /// May be repeated, also after one that its `interrupt` ended early, and whether or not the
    /// options' own is set by then; not after run. `statistics` may be null; its times and counters of work sum
    /// up over repetitions, what it says of voxels and slices is of these slabs.
    virtual Result<SlabsRun> run_slabs(std::span<const int32_t> slabs, pipeline::SliceSink& sink,
                                       const std::atomic<bool>& interrupt,
                                       PrintStatistics* statistics) = 0;
};

}  // namespace openfab::pipeline
