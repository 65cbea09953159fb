// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a scheduled kernel stores between its stages, from its lowered code: before it has ever run.

#include <Halide.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/lower/scheduled_kernel.h"

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

/// Returns the kernel's Func whose storage has this name of Halide's; null where there is none.
const ScheduledFunc* func_of_storage(const ScheduledKernel& kernel, const std::string& name);

}  // namespace openfab::lower
