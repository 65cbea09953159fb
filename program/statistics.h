// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes the statistics of a print as JSON (`--stats`).

#include <filesystem>
#include <string>

#include "base/json_text.h"
#include "base/result.h"
#include "runtime/pipeline/print_job.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::program {

/// Returns one JSON object, indented, snake_case keys; ends with a new line. Volumes are
/// millilitres, times seconds, rates millions of voxels a second of the tight box and of solid
/// voxels, without slices that were resumed.
std::string statistics_json(const pipeline::PrintStatistics& statistics,
                            const pipeline::PrintInfo& info);

/// Writes the members `size_voxels` and `pitch_mm` of an object.
void write_grid(const Vec3i& size_voxels, const pipeline::PrintInfo& info, JsonText* w);

/// Writes the member `cost` of an object.
void write_cost(const pipeline::PrintCost& cost, JsonText* w);

/// Writes the statistics to a file, replacing it.
Result<void> write_statistics(const std::filesystem::path& file,
                              const pipeline::PrintStatistics& statistics,
                              const pipeline::PrintInfo& info);

/// Returns the warning for a print without any voxel of material; empty where it has one. `sizes` is of
/// PrintJob::part_sizes.
std::string nothing_printed(const pipeline::PrintStatistics& statistics, const std::string& sizes);

}  // namespace openfab::program
