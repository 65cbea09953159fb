// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a print costs on its printer, in money and time, by the `cost` of the printer's process.

#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/pipeline/print_statistics.h"
#include "runtime/pipeline/slice_sink.h"
#include "world/printer.h"

namespace openfab::program {

/// Returns the time that the printer takes for so many slices of the print's size; 0 where it is not
/// known.
double print_seconds(const world::Printer& printer, const pipeline::PrintInfo& info,
                     int32_t slices);

/// Returns the cost of slices that hold so many millilitres by code; nothing where the profile has no
/// prices.
std::optional<pipeline::PrintCost> print_cost(const world::Printer& printer,
                                              const pipeline::PrintInfo& info, int32_t slices,
                                              const std::vector<double>& ml_by_code);

/// Adds time and cost on the printer to the statistics of a print.
void add_cost(const world::Printer& printer, const pipeline::PrintInfo& info,
              pipeline::PrintStatistics* statistics);

/// Returns the millilitres by code of voxels.
std::vector<double> ml_by_code(const std::vector<int64_t>& voxels_by_code, double voxel_ml);

}  // namespace openfab::program
