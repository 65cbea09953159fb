// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a scheduled kernel stores between its stages, from its lowered code: before it has ever run.
// An extern stage is taken to read, along vars that it shares with what it reads, no more than it is
// asked for; vars of its input alone have bounds of their own (compiler/lower/sample.cpp).

#include <Halide.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/lower/apply_schedule.h"

namespace openfab::lower {

/// An upper bound for one call: `fixed_bytes + place_bytes * n`, where n is the longest extent of a
/// buffer that is not fixed: blocks, vertices, groups. In a parallel loop each thread that takes
/// part holds as much, at most.
struct KernelMemory {
    int64_t fixed_bytes = 0;
    int64_t place_bytes = 0;
    int64_t stack_bytes = 0;  ///< of that, in the frames of functions

    int64_t bytes(int64_t n) const { return fixed_bytes + place_bytes * n; }
};

/// One Func's storage, for n places.
struct FuncStorage {
    std::string func;  ///< Halide's name
    int64_t bytes = 0;
};

/// Returns nothing where the size of a Func's storage depends on data: its name is in `unbounded`.
std::optional<KernelMemory> measure_memory(const ScheduledKernel& kernel,
                                           const Halide::Module& module,
                                           std::string* unbounded = nullptr);

/// Returns what each allocation takes at n places.
std::vector<FuncStorage> list_storage(const ScheduledKernel& kernel, const Halide::Module& module,
                                      int64_t places);

/// Limits of a user's schedule, for each thread.
constexpr int64_t kMostScratchBytes = int64_t{64} << 20;
constexpr int64_t kMostStackBytes = int64_t{1} << 20;

/// Finds what only the lowered code tells: storage that is too large, folds and bounds of storage
/// that are not proved to be enough. `places`: as in KernelMemory, in the longest call.
std::optional<ScheduleFault> check_lowered(const Schedule& schedule, const ScheduledKernel& kernel,
                                           const Halide::Module& module, int64_t places);

}  // namespace openfab::lower
