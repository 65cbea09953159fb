// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiles stages to machine code. Different stages may be compiled in different threads at once.

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/schedule.h"

namespace openfab::lower {

const char* isa_name(openfab_isa isa);

/// Returns the name of a kernel's schedule file: "surface", "surface_bounds", "volume",
/// "volume_bounds", …
const char* schedule_name(ir::StageKind kind);
/// Returns those of all kinds.
const std::vector<std::string>& pipeline_names();

/// Why a compilation ended: a fault of the user's schedule, or a bug of ours.
struct Fault {
    std::optional<ScheduleFault> schedule;
    std::string internal;
};

struct KernelRequest {
    const ir::Stage* stage = nullptr;
    std::string function;  ///< C name; its argv form is `<function>_argv`
    openfab_isa isa = OPENFAB_ISA_SSE41;
    const Schedule* schedule = nullptr;  ///< null: the default one of the kernel and target
};

/// Writes an object file with `function` and `function_argv` that needs a Halide runtime to link.
std::optional<Fault> compile_object(const KernelRequest& request, const std::string& path);

/// A kernel compiled into this process; the code lives as long as a copy of this does.
struct LoadedKernel {
    std::shared_ptr<void> code;
    openfab_kernel_fn function = nullptr;
};

/// Compiles a kernel into this process, without files, assembler or linker. Errors and parallel
/// loops of the kernel go through abi/halide_hooks.h.
std::variant<LoadedKernel, Fault> compile_in_memory(const KernelRequest& request);

enum class TextForm { kHalide, kSchedule, kLoops, kStmt, kLlvm, kAsm };

/// Returns the kernel as text. kHalide is the list of Funcs with their expressions; kSchedule the
/// schedule in force, as a file; kLoops the loops that it makes.
std::variant<std::string, Fault> emit_text(const KernelRequest& request, TextForm form);

}  // namespace openfab::lower
