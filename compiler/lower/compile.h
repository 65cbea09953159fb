// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiles stages to machine code. Different stages may be compiled in different threads at once.

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "abi/kernel_call.h"
#include "compiler/ir/ir.h"
#include "compiler/lower/args.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

using abi::isa_name;

/// Returns the name of a kernel's schedule file: "surface", "surface_bounds", "slab",
/// "volume_bounds", …
const char* schedule_name(ir::StageKind kind);
/// Returns those of all kinds.
const std::vector<std::string>& pipeline_names();

/// Why a compilation ended: a fault of the user's schedule, or a bug of ours.
struct Fault {
    std::optional<schedule::Fault> schedule;
    std::string trouble;      ///< without a schedule to blame
    bool is_outside = false;  ///< the trouble is the machine's: memory, descriptors, space, no tool
};

struct KernelRequest {
    const ir::Stage* stage = nullptr;
    SlabStages inside;     ///< of a volume stage: see make_kernel
    std::string function;  ///< C name; its argv form is `<function>_argv`
    openfab_isa isa = OPENFAB_ISA_SSE41;
    const schedule::Schedule* schedule = nullptr;  ///< null: the default one
    bool profiled = false;                         ///< see kernel_profile.h
};

/// Returns what to do where a library or tool says that the system gave no memory, no descriptors or
/// no space; else an empty text. `folder`: where it wrote, if that is none for temporary files.
std::string remedy_of(const std::string& trouble, const std::filesystem::path& folder = {});

/// Makes a fault of what a library or tool says: the machine's where the system gave no memory, no
/// descriptors or no space, with what to do; else one of ours.
Fault fault_of(std::string trouble);

/// Returns the schedule of a kernel: the request's, else the built-in one.
const schedule::Schedule& schedule_of(const KernelRequest& request);

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
