// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// `openfab tune`: searches the schedule of the slab kernel with which a world prints fastest.

#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/driver/options.h"

namespace openfab::tuner {

struct TuneOptions {
    driver::ScheduleOptions schedules;
    std::string output;   ///< FILE.sched
    std::string journal;  ///< empty: beside the output
    double budget_seconds = 300;
    std::vector<std::string> print;  ///< the print's own options
};

/// Runs the command. Interrupted, it writes the best schedule that it has.
Result<void> run_tune(const TuneOptions& options);

}  // namespace openfab::tuner
