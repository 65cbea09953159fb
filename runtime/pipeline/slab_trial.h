// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints a slab, or some of its rows, on trial.

#include <atomic>
#include <cstdint>

#include "base/result.h"
#include "runtime/pipeline/print_setup.h"
#include "runtime/pipeline/slab_loop.h"
#include "runtime/pipeline/slice_sink.h"
#include "runtime/pipeline/time_sample.h"

namespace openfab::pipeline {

/// Takes slices of slabs on trial as if they followed each other.
struct TrialSlices {
    SliceSink* sink;  ///< may be null
    int32_t next;
};

/// Does what TrySlab says. The coverage of the first slab has time of its own, and its seconds begin
/// with its blocks: its time is not known without some of them.
Result<SlabTrial> try_slab(const PrintSetup& setup, SlabLoop* loop, const SlabTry& wanted,
                           const std::atomic<bool>& interrupt, TrialSlices* slices);

}  // namespace openfab::pipeline
