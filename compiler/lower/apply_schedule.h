// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Applies a schedule to a kernel's Funcs. Only names of our own map are looked up.

#include <optional>

#include "compiler/lower/kernel.h"
#include "compiler/lower/schedule.h"

namespace openfab::lower {

/// The first `line_count` lines. Errors that Halide raises on the way become a fault on that line.
/// Needs a Halide that was built with exceptions; one without ends the process with Halide's
/// message.
std::optional<ScheduleFault> apply_schedule(const Schedule& schedule, size_t line_count,
                                            Kernel* kernel);

/// Whether the line's func is this, or its pattern fits.
bool is_about(const ScheduleLine& line, std::string_view func);

/// Fault on a line as a whole, for what Halide finds only when it lowers the pipeline.
ScheduleFault fault_on_line(const ScheduleLine& line, const std::string& halide_message);

}  // namespace openfab::lower
