// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Functions of ours that generated code calls: errors are stored, never fatal, and parallel loops
// run on the one thread pool. Code that is linked in gets both from the stage table
// (libopenfab_kernels), code that is compiled in memory from compiler/lower.

#include <cstdint>
#include <string>

namespace openfab::abi {

/// Halide's error handler: stores the message for take_kernel_error.
void keep_kernel_error(void* user_context, const char* message);

using KernelTask = int (*)(void* user_context, int index, uint8_t* closure);
/// Halide's parallel loop: runs `task` for min .. min + size - 1. Returns 0, or the status of one
/// that failed.
int run_kernel_loop(void* user_context, KernelTask task, int min, int size, uint8_t* closure);

/// Returns and clears the message of the last error that generated code reported on this thread.
/// Parallel loops of a kernel may report on another thread, so an empty text does not mean success:
/// check the kernel's status.
std::string take_kernel_error();

}  // namespace openfab::abi
