// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the report of `--estimate`: sizes and memory from the set-up, materials from a coarse print
// without output, time from some slabs. They are given a few seconds together, and are scaled from what
// is done by then.

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/common/format.h"
#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_job.h"
#include "world/printer.h"

namespace openfab::program {

struct Estimate {
    pipeline::PrintEstimate set_up;
    int64_t memory_bytes = 0;  ///< with previews
    int32_t slices = 0;
    Vec3d printer_pitch_mm;    ///< 0: not known
    double print_seconds = 0;  ///< on the printer; 0 where its layer time is not known
    std::string
        no_print_seconds;  ///< why its profile has no time of a layer; empty: it does not say
    std::optional<pipeline::PrintCost> cost;  ///< where the printer's profile has prices
    /// Statistics of a coarse print; each material is within a few per cent where its parts are
    /// thicker than a few of its voxels. Empty for a dry run, and where even the coarsest took too
    /// long.
    pipeline::PrintStatistics sample;
    double sample_voxel_ml = 0;
    bool few_voxels = false;    ///< in the coarse print: a finer one would take too long
    pipeline::TimeSample time;  ///< without places for a dry run
    std::vector<std::string> warnings;

    /// The time that the print will take here.
    double seconds() const { return time.places > 0 ? time.seconds : set_up.seconds; }
    /// Of the slabs that were sampled.
    double slowest_slice_seconds() const { return time.slowest_slab_seconds / 8; }
    /// Returns whether a printer whose layer time is known never waits, once it has the first
    /// slices.
    bool keeps_up() const { return slowest_slice_seconds() * slices <= print_seconds; }
};

/// Makes an estimate; `input` is that of `print`, for a second print at a coarser pitch, which gets
/// the memory of the first; `format`: see choose_format.
Result<Estimate> make_estimate(std::unique_ptr<pipeline::PrintJob> print,
                               const pipeline::PrintInput& input,
                               const pipeline::PrintOptions& pipeline, const Options& options,
                               const backends::Format* format, const world::Printer& printer,
                               const std::atomic<bool>& interrupt);

/// Writes the estimate to stderr.
void show_estimate(const Estimate& estimate, const pipeline::PrintInfo& info);

/// Returns one JSON object, with the keys of a print's statistics.
std::string estimate_json(const Estimate& estimate, const pipeline::PrintInfo& info);

/// Writes it to the file of `--stats`.
Result<void> write_estimate(const std::string& file, const Estimate& estimate,
                            const pipeline::PrintInfo& info);

}  // namespace openfab::program
