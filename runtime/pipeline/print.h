// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print: parts on a grid, run group of 8 slices after group, bottom up, into a sink, under a
// memory budget.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "runtime/dither/dither_rule.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::slab {

struct PrintOptions {
    int64_t memory_bytes = 1'500'000'000;  ///< without what is reserved
    int64_t reserved_bytes = 0;            ///< of the user's budget, for what others hold: previews
    int32_t threads = 0;                   ///< 0: all cores
    std::string dither = kDefaultDitherName;
    uint64_t seed = 0;
    std::optional<Vec2<double>> z_range_mm;  ///< --z, above the grid's lowest corner
    std::optional<Vec2<int32_t>> slices;     ///< --slices A:B, B exclusive
    bool culling = true;  ///< off: every covered block is evaluated voxel by voxel
    bool infer_identity = true;
    int32_t groups_in_flight =
        0;  ///< 0: from threads and memory; tests vary it, the output never depends on it
    /// Where culling leaves more blocks of the first group, its first slice is printed by itself
    /// and then the rest of them, which evaluates the blocks twice: a second or so, once, so that
    /// whoever waits for the slice has it seconds sooner. Tests vary it, too.
    int64_t most_blocks_at_first = 40'000;
    openfab_isa isa = OPENFAB_ISA_AVX2;
    /// Once set, whatever runs ends soon: set-up with an error. It outlives the print.
    const std::atomic<bool>* interrupt = nullptr;
    bool interrupted() const {
        return interrupt != nullptr && interrupt->load(std::memory_order_relaxed);
    }
    int64_t sink_bytes_per_column = 0;  ///< what the sink keeps for each voxel of a slice
    /// What the sink takes for each voxel of a slice while it encodes it. Only as many slices are
    /// encoded at once as a third of the budget has room for.
    int64_t encode_bytes_per_column = 0;
    /// Takes the lines of printf, in an order that no thread changes; called from one thread.
    std::function<void(const std::string& line)> print_line;
};

struct PrintInput {
    std::vector<scene::Part> parts;                  ///< in build order
    std::vector<backends::SliceMaterial> materials;  ///< code 1 is materials[0]
    /// The code of the material that void voxels below parts get; 0: none do.
    int32_t support_code = 0;
    Vec3d pitch_mm;
    std::optional<Box3d> crop_mm;  ///< what the grid covers besides the parts
    std::string printer;
    std::string title;
    std::vector<std::string> warnings;  ///< carried to the statistics
};

/// What `--estimate` shows, known after set-up and before the first slice.
struct PrintEstimate {
    Vec3i size;
    int64_t voxels_total = 0;
    int64_t memory_bytes = 0;
    double seconds = 0;
};

/// Everything that `--stats` writes; names are those of its keys.
struct PrintStatistics {
    int64_t voxels_total = 0;  ///< tight box of what was printed
    int64_t voxels_solid = 0;  ///< without support
    int64_t voxels_support = 0;
    std::vector<int64_t> voxels_by_code;
    Box3i tight;
    int32_t slices = 0;
    double seconds_total = 0;        ///< from the start of the process
    double seconds_first_slice = 0;  ///< likewise
    std::vector<std::pair<std::string, double>> seconds_by_phase;  ///< summed over threads
    int64_t peak_rss_bytes = 0;
    int32_t threads = 0;
    int64_t blocks_total = 0, blocks_filled = 0, blocks_evaluated = 0;
    int64_t queries_asked = 0, queries_skipped = 0;
    int64_t cache_hits = 0, cache_misses = 0, cache_evictions = 0, cache_peak_bytes = 0;
    int64_t weights_not_usable = 0;  ///< negative or NaN amounts, taken as 0
    int64_t displacements_not_finite = 0, displacements_cut = 0;
    uint64_t hash = 0;  ///< of all slices' packed rows
    bool complete = false;
    double layer_time_s = 0;  ///< of the printer; 0: unknown
    /// Of the above those that an earlier print had written; the rest of the figures, and the
    /// times, are this one's.
    int32_t slices_kept = 0;
    int64_t voxels_solid_kept = 0;      ///< without support
    std::vector<std::string> warnings;  ///< those of the input, and the next
    std::vector<std::string> overlaps;  ///< of parts of equal priority, for people
};

/// Of voxels_total those that this print has made itself: its share of the slices.
inline int64_t voxels_printed(const PrintStatistics& s) {
    return s.slices_kept == 0 ? s.voxels_total
                              : s.voxels_total / s.slices * (s.slices - s.slices_kept);
}

/// Told after each committed slice; called from one thread.
struct ProgressEvent {
    int32_t slices_done = 0, slices_total = 0;
    int64_t voxels_done = 0, voxels_total = 0;
    double seconds = 0;
};

class Print {
  public:
    /// Surfaces, displacement bounds, query trees, grid. Refuses what cannot fit the budget, with
    /// the least that would do.
    static Result<std::unique_ptr<Print>> create(PrintInput input, PrintOptions options);
    virtual ~Print() = default;

    virtual const backends::PrintInfo& info() const = 0;
    virtual PrintEstimate estimate() const = 0;
    /// Runs to the end, or until `interrupt` is set or the sink fails; whole slices written stay.
    /// The statistics are valid in every case; the Result tells why it ended early. Calls
    /// sink.begin, encode, commit and finish.
    virtual Result<void> run(backends::SliceSink& sink,
                             const std::function<void(const ProgressEvent&)>& progress,
                             const std::atomic<bool>& interrupt, PrintStatistics* statistics) = 0;
};

}  // namespace openfab::slab
