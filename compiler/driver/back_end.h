// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by `build`, `check` and `emit`: running the requested passes, and reports of what failed.

#include "compiler/driver/commands.h"
#include "compiler/lower/code/compile.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

/// Runs the pipeline, with the requested dumps and times to stderr.
passes::PipelineResult run_passes(const ir::Fablet& fablet, const BackEndOptions& options,
                                  bool amounts_in_states = false);

/// Reports a stage, or a dither rule, that is longer than what is compiled, where it gets too long;
/// returns whether one is.
bool refuse_long_stages(const ir::Fablet& fablet, const passes::PipelineResult& result,
                        diag::Sink* sink);

/// Prints why a compilation failed. Returns an exit code.
int report_fault(const lower::Fault& fault, const source::SourceManager& sources,
                 const CommonOptions& common);

}  // namespace openfab::driver
