// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print says of itself: before, meanwhile and afterwards.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"

namespace openfab::pipeline {

/// The figures of `--estimate`, known after set-up and before the first slice.
struct PrintEstimate {
    Vec3i size;
    int64_t voxels_total = 0;
    int64_t memory_bytes = 0;
    double seconds = 0;  ///< at a typical rate
};

/// What one material of a print costs.
struct MaterialCost {
    std::string name;
    double ml = 0, waste_ml = 0;
    std::optional<double> money;  ///< of both; nothing where its price is not known
};

/// What a print costs on its printer.
struct PrintCost {
    std::string currency;
    std::vector<MaterialCost> materials;
    double money = 0;    ///< of those whose price is known
    double seconds = 0;  ///< 0: not known
    int64_t passes = 0;
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
    int64_t voxels_mixed = 0;        ///< of this print, before the dither
    int64_t weights_not_usable = 0;  ///< negative or NaN amounts, replaced by 0
    int64_t displacements_not_finite = 0, displacements_cut = 0;
    uint64_t hash = 0;  ///< of all slices' packed rows
    bool complete = false;
    double print_seconds = 0;  ///< on the printer; 0: unknown
    std::optional<PrintCost> cost;
    /// Slices that an earlier print had written; the times and the other counters are this print's
    /// alone.
    int32_t slices_resumed = 0;
    int64_t voxels_solid_resumed = 0;   ///< without support
    std::vector<std::string> warnings;  ///< those of the input, and `late_warnings`
    /// What only printing shows: parts of equal priority that overlap, displacements that were changed.
    std::vector<std::string> late_warnings;
    /// What may well be meant: places of parts that get no material.
    std::vector<std::string> notes;
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

}  // namespace openfab::pipeline
