// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Applies a schedule to a kernel's Funcs. Only names of Kernel::funcs are visible. Each directive is
// checked in our words before Halide sees it; what only the whole schedule tells is checked at the
// end. Needs a Halide built with exceptions; without, an error ends the process with Halide's
// message.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "compiler/lower/schedule/scheduled_kernel.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

/// Limits of what a schedule may ask for: beyond them code takes minutes to compile.
constexpr int64_t kMostVectorLanes = 64;  ///< in all vectorized loops of a Func together
constexpr int64_t kMostUnrolled = 128;    ///< copies, likewise
constexpr size_t kMostVars = 64;          ///< that the loops of a definition have, or had
constexpr size_t kMostSpecializations = 16;

/// Schedules the kernel's Funcs. `built_in`: what it stores is known to fit a thread's stack.
std::variant<ScheduledKernel, schedule::Fault> apply_schedule(const schedule::Schedule& schedule,
                                                              const Kernel& kernel,
                                                              bool built_in = false);

/// Finds Funcs that are computed or stored where what reads them is not.
std::optional<schedule::Fault> check_placements(const ScheduledKernel& kernel);

/// Operations of one Func with all that is inline in it, counted where each is used: Halide walks
/// them all, several times.
constexpr double kMostInlined = 4e6;

/// Finds Funcs that grow beyond kMostInlined by what is inline in them.
std::optional<schedule::Fault> check_inlining(const schedule::Schedule& schedule,
                                              const ScheduledKernel& kernel);

/// Of a kernel's lowered code, where what is unrolled stands as often as it is written out. LLVM's
/// time grows with the third power of such loops: 8 s at 200 of them, minutes at 400.
constexpr int64_t kMostLoops = 256;
constexpr int64_t kMostOperations = 400'000;

/// Finds whether a schedule makes far more code than that, from the code before its loops are
/// unrolled: so much is not lowered.
std::optional<schedule::Fault> check_copies(const schedule::Schedule& schedule,
                                            const ScheduledKernel& kernel,
                                            const Halide::Module& module);

/// Finds whether a schedule makes more code than that.
std::optional<schedule::Fault> check_code_size(const schedule::Schedule& schedule,
                                               const ScheduledKernel& kernel,
                                               const Halide::Module& module);

/// Returns the fault of a schedule that Halide refused while it lowered the kernel; `message` is
/// Halide's, which no one sees.
schedule::Fault fault_of_lowering(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
                                  const std::string& message);

/// Returns the fault of a `bound_storage` or `fold_storage` that is not proved to hold all that is
/// in use at a time.
schedule::Fault storage_fault(const schedule::Word& directive, const std::string& func);
/// Returns the same for the `bound_storage` of a Func that `text` names, maybe among others.
schedule::Fault fault_of_bound(const schedule::Schedule& schedule, const ScheduledKernel& kernel,
                               const std::string& text);

}  // namespace openfab::lower
