// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Applies a schedule to a kernel's Funcs. Only names of Kernel::funcs are visible.

#include <optional>

#include "compiler/lower/kernel.h"
#include "compiler/lower/schedule.h"

namespace openfab::lower {

/// Applies the first `line_count` lines. Errors that Halide raises become a fault on that line.
/// Needs a Halide built with exceptions; without, an error ends the process with Halide's message.
std::optional<ScheduleFault> apply_schedule(const Schedule& schedule, size_t line_count,
                                            Kernel* kernel);

/// True if the line names `func`, or its pattern matches it.
bool names_func(const ScheduleLine& line, std::string_view func);

/// Returns a fault on a whole line, for errors that Halide finds only when it lowers the pipeline.
ScheduleFault fault_on_line(const ScheduleLine& line, const std::string& halide_message);

}  // namespace openfab::lower
