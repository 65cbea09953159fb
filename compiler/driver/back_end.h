// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by `build` and `emit`: running the requested passes, and user schedules.

#include <string>
#include <vector>

#include "compiler/driver/commands.h"
#include "compiler/lower/compile.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

/// Runs the pipeline, with the requested dumps and times to stderr.
passes::PipelineResult run_passes(const ir::Fablet& fablet, const BackEndOptions& options);

struct UserSchedule {
    std::string kernel;  ///< empty: none
    uint32_t file = 0;
    lower::Schedule schedule;
};

/// Reads and parses a schedule file; the kernel is the first part of its name (`volume.sched`,
/// `volume.avx2.sched`). Returns an exit code; errors have been printed.
int load_schedule(const std::string& path, source::SourceManager* sources,
                  const CommonOptions& common, UserSchedule* out);

/// Prints why a compilation failed. Returns an exit code.
int report_fault(const lower::Fault& fault, const UserSchedule& schedule,
                 const source::SourceManager& sources, const CommonOptions& common);

}  // namespace openfab::driver
