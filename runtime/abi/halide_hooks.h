// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What generated code calls of us: errors are kept, never fatal, and parallel loops run on the one
// pool of threads.

#include <string>

namespace openfab::abi {

/// Makes all generated code of the process use the two; the stage table (libopenfab_kernels) calls
/// it when it is linked in.
void install_halide_hooks();

/// The message of the last error that generated code reported on this thread; cleared by the call.
/// Parallel loops of a kernel may report on another thread, so an empty text does not mean that
/// nothing failed: read the kernel's status.
std::string take_kernel_error();

}  // namespace openfab::abi
