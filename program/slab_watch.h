// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Watches a print for slabs that take long: it says which, and ends it after `--slab-limit`.

#include <atomic>
#include <functional>
#include <optional>

#include "backends/job/record.h"
#include "program/options.h"
#include "program/progress.h"
#include "runtime/pipeline/print_job.h"
#include "runtime/pipeline/slab_clock.h"

namespace openfab::program {

/// What is told of a slab and when; times come from the caller.
class SlabPatience {
  public:
    explicit SlabPatience(std::optional<double> limit_seconds) : limit_(limit_seconds) {}

    /// Returns whether to tell of the slab now: after half a minute, and each time after twice as long.
    bool tells(const pipeline::SlabClock::Slab& slab, double now_seconds);
    bool is_over(const pipeline::SlabClock::Slab& slab, double now_seconds) const {
        return limit_ && now_seconds - slab.began_seconds > *limit_;
    }

  private:
    std::optional<double> limit_;
    double began_ = -1, due_ = 0;  ///< of the slab that was told of
};

/// Runs a print whose options have `clock`, as PrintJob::run does; fails with a user error after the limit.
/// `record`, if there is one, is told at once that the print is to stop.
Result<void> run_watched(pipeline::PrintJob* print, pipeline::SliceSink& sink,
                         const std::function<void(const pipeline::ProgressEvent&)>& update,
                         const std::atomic<bool>& interrupt, const pipeline::SlabClock& clock,
                         const Options& options, Progress* progress,
                         pipeline::PrintStatistics* statistics, job::Record* record = nullptr);

}  // namespace openfab::program
