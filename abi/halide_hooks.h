// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What generated code calls of us: errors are kept, never fatal, and parallel loops run on the one
// pool of threads. Code that is linked in gets both from the stage table (libopenfab_kernels), code
// that is compiled in memory from compiler/lower.

#include <cstdint>
#include <string>

namespace openfab::abi {

/// Halide's error handler: keeps the message for take_kernel_error.
void keep_kernel_error(void* user_context, const char* message);

using KernelTask = int (*)(void* user_context, int index, uint8_t* closure);
/// Halide's parallel loop: `task` for min .. min + size - 1; 0, or the status of one that failed.
int run_kernel_loop(void* user_context, KernelTask task, int min, int size, uint8_t* closure);

/// The message of the last error that generated code reported on this thread; cleared by the call.
/// Parallel loops of a kernel may report on another thread, so an empty text does not mean that
/// nothing failed: read the kernel's status.
std::string take_kernel_error();

}  // namespace openfab::abi
