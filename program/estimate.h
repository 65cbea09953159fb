// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Makes the report of `--estimate`: sizes, memory and time from the set-up, materials from a coarse
// print without output.

#include <atomic>
#include <string>

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print_job.h"
#include "world/printer.h"

namespace openfab::program {

struct Estimate {
    pipeline::PrintEstimate set_up;
    int64_t memory_bytes = 0;  ///< with previews
    int32_t slices = 0;
    double print_seconds = 0;  ///< on the printer; 0 where its layer time is not known
    /// Statistics of at most about 4 million voxels; each material is within a few per cent where
    /// its parts are thicker than a few voxels. Empty for a dry run.
    pipeline::PrintStatistics sample;
    double sample_voxel_ml = 0;
};

/// Makes an estimate; `input` is that of `print`, for a second print at a coarser pitch.
Result<Estimate> make_estimate(const pipeline::PrintJob& print, pipeline::PrintInput input,
                               const pipeline::PrintOptions& pipeline, const Options& options,
                               const world::Printer& printer, const std::atomic<bool>& interrupt);

/// Writes the estimate to stderr.
void show_estimate(const Estimate& estimate, const pipeline::PrintInfo& info);

/// Writes the file of `--stats`: one JSON object, with the keys of a print's statistics.
Result<void> write_estimate(const std::string& file, const Estimate& estimate,
                            const pipeline::PrintInfo& info);

}  // namespace openfab::program
