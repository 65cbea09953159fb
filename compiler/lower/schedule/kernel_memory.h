// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a scheduled kernel stores between its stages, from its lowered code: before it has ever run.
// An extern stage is taken to read, along vars that it shares with what it reads, no more than it is
// asked for; vars of its input alone have bounds of their own (compiler/lower/algorithm/sample.cpp).

#include <Halide.h>

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/lower/schedule/apply_schedule.h"

namespace openfab::lower {

/// Upper bounds for one call of a kernel. In a parallel loop each thread that takes part holds as
/// much, at most.
struct KernelMemory {
    int64_t bytes = 0;
    int64_t stack_bytes = 0;  ///< of that, in the frames of functions
};

/// One Func's storage.
struct FuncStorage {
    std::string func;  ///< Halide's name
    int64_t bytes = 0;
};

/// Returns what a call takes whose buffers have at most `places` columns, vertices, groups or blocks;
/// nothing where the size of a Func's storage depends on data: its name is in `unbounded`.
std::optional<KernelMemory> measure_memory(const ScheduledKernel& kernel,
                                           const Halide::Module& module, int64_t places,
                                           std::string* unbounded = nullptr);

/// Returns what each allocation takes at n places.
std::vector<FuncStorage> list_storage(const ScheduledKernel& kernel, const Halide::Module& module,
                                      int64_t places);

/// Returns whether Halide takes it from the stack: what asks for it, and what is small.
bool is_on_stack(const Halide::Internal::Allocate& op);

/// Limits of a user's schedule, for each thread.
constexpr int64_t kMostStoredBytes = int64_t{64} << 20;
constexpr int64_t kMostStackBytes = int64_t{1} << 20;

/// Finds a part of a loop that is to be vectorized and is not as long wherever the Func is computed, in
/// code in which it is a loop still.
std::optional<schedule::Fault> check_part_vectors(const ScheduledKernel& kernel,
                                                  const Halide::Module& module);

/// Finds what only the lowered code tells: storage that is too large, folds and bounds of storage
/// that are not proved to be enough. Else returns what it takes.
std::variant<KernelMemory, schedule::Fault> check_lowered(const schedule::Schedule& schedule,
                                                          const ScheduledKernel& kernel,
                                                          const Halide::Module& module,
                                                          int64_t places);

}  // namespace openfab::lower
