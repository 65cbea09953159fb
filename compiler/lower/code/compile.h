// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "compiler/lower/code/fault.h"
#include "compiler/lower/schedule/kernel_request.h"

namespace openfab::lower {

/// Returns text of all that decides the code of a kernel, but for its function's name and what this
/// program itself is: a kernel of the same text is the same kernel.
std::string code_source(const KernelRequest& request);

/// A kernel in machine code.
struct CompiledKernel {
    std::string code;          ///< of an object file, see compile_object
    int64_t stored_bytes = 0;  ///< what a call stores between its stages at most, in each thread
};

/// Returns an object file with `function` and `function_argv`, which needs a Halide runtime to link.
std::variant<CompiledKernel, Fault> compile_object(const KernelRequest& request);

enum class TextForm { kHalide, kSchedule, kLoops, kStmt, kLlvm, kAsm };

/// Returns the kernel as text. kHalide is the list of Funcs with their expressions; kSchedule the
/// schedule in force, as a file; kLoops the loops that it makes.
std::variant<std::string, Fault> emit_text(const KernelRequest& request, TextForm form);

}  // namespace openfab::lower
