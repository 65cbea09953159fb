// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `--estimate` tells: sizes, memory and time from the set-up, materials from a coarse print
// that goes nowhere.

#include <atomic>
#include <string>

#include "base/result.h"
#include "program/options.h"
#include "runtime/pipeline/print.h"
#include "world/printer.h"

namespace openfab::print {

struct Estimate {
    slab::PrintEstimate set_up;
    int64_t memory_bytes = 0;  ///< with previews
    int32_t slices = 0;
    double print_seconds = 0;  ///< on the printer; 0 where its layer time is not known
    /// From at most about 4 million voxels; each material's within a few per cent where its parts
    /// are thicker than a few voxels. Empty for a dry run.
    slab::PrintStatistics sample;
    double sample_voxel_ml = 0;
};

/// `input` is that of `print`, for a second print at a coarser pitch.
Result<Estimate> make_estimate(const slab::Print& print, slab::PrintInput input,
                               const slab::PrintOptions& pipeline, const Options& options,
                               const scene::Printer& printer, const std::atomic<bool>& interrupt);

/// To stderr.
void show_estimate(const Estimate& estimate, const backends::PrintInfo& info);

/// With `--stats`: one JSON object, keys as those of a print's statistics.
Result<void> write_estimate(const std::string& file, const Estimate& estimate,
                            const backends::PrintInfo& info);

}  // namespace openfab::print
