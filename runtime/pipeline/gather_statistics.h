// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Gathers what a print says of itself from the slab loop's parts.

#include "runtime/pipeline/print_setup.h"
#include "runtime/pipeline/print_statistics.h"
#include "runtime/pipeline/slab_loop.h"
#include "runtime/pipeline/slice_committer.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::pipeline {

/// Sets all figures but those of fill_voxels. `seconds_finish`: that the sink took to finish.
void gather_statistics(const PrintSetup& setup, const SlabLoop& loop,
                       const SliceCommitter& committer, double seconds_finish,
                       PrintStatistics* statistics);

/// Sets the counts of voxels.
void fill_voxels(const PrintTotals& totals, int32_t support_code, PrintStatistics* statistics);

}  // namespace openfab::pipeline
