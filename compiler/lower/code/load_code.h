// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Object files of kernels as code in this process: what a linker and the system's loader do for a
// print program, without a file or a program to start, in well below a millisecond. Kernels are
// position-independent, so few forms of relocation occur; any other is refused.

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "abi/fablet_table.h"

namespace openfab::lower {

/// A kernel in this process; the code lives as long as a copy of this does.
struct LoadedKernel {
    std::shared_ptr<void> code;
    openfab_kernel_fn function = nullptr;
};

/// Returns the address of a function that kernels call, as a print program is linked with it; null
/// where there is none of the name. (kernel_symbols.cpp)
const void* kernel_symbol(std::string_view name);

/// Loads an object file for this machine and returns its function `function`; else what is wrong with it,
/// as text: it must come from a compiler, not from a user.
std::variant<LoadedKernel, std::string> load_code(std::string_view object,
                                                  std::string_view function);

/// Returns a kernel that calls `function` with its arguments and `context`.
std::variant<LoadedKernel, std::string> bind_code(int (*function)(void** args, void* context),
                                                  void* context);

}  // namespace openfab::lower
