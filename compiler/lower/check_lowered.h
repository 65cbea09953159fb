// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What only the lowered code tells of a user's schedule.

#include <Halide.h>

#include <cstdint>
#include <variant>

#include "compiler/lower/kernel_memory.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

/// Limits of a user's schedule, for each thread.
constexpr int64_t kMostStoredBytes = int64_t{64} << 20;
constexpr int64_t kMostStackBytes = int64_t{1} << 20;

/// Finds storage that is too large, and checks of the code's own that are not certain to hold in every
/// call: of folds and bounds of storage, of what a Func is computed for, of what is read of buffers.
/// Else returns what the kernel stores.
std::variant<KernelMemory, schedule::Fault> check_lowered(const schedule::Schedule& schedule,
                                                          const ScheduledKernel& kernel,
                                                          const Halide::Module& module,
                                                          int64_t places);

}  // namespace openfab::lower
