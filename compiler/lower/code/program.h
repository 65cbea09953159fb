// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiles fablets to object files: kernels in parallel threads, and the C table that names them.

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/lower/code/compile.h"
#include "compiler/lower/code/table.h"

namespace openfab::lower {

/// Schedules in place of the default ones, by pipeline ("slab") and instruction set.
using ScheduleSet = std::map<std::pair<std::string, openfab_isa>, schedule::Schedule>;

struct ProgramOptions {
    std::vector<openfab_isa> isas = {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2};
    ScheduleSet schedules;
    int threads = 0;               ///< 0: all cores
    std::string compiler = "cc";   ///< C compiler for the table, and linker
    KernelCache* cache = nullptr;  ///< null: every kernel is compiled
    /// Called at most once, from any thread, with how long the rest will take, if that is long: after
    /// the first seconds, if so many more are left.
    std::function<void(const std::string&)> foretell;
    double foretell_after = 2, foretell_from = 3;
    /// load_program alone: kernels that a print can do without are compiled while it runs.
    bool bounds_later = false;
    bool profiled = false;  ///< load_program alone: see kernel_profile.h
};

/// What it took to make one kernel.
struct KernelTime {
    std::string kernel;     ///< "slab avx2"
    double seconds = 0;     ///< of a processor
    bool compiled = false;  ///< else it was in the cache
};

struct MadeKernels {
    std::vector<std::shared_ptr<const KernelObject>> objects;  ///< of each unit
    std::vector<KernelTime> times;                             ///< of each different one
};

struct ProgramTimes {
    double kernels = 0;  ///< seconds on the clock
    double table = 0;
    std::vector<KernelTime> each;
};

struct ProgramObjects {
    std::vector<std::filesystem::path> objects;  ///< kernels, then the table
    ProgramTimes times;
};

/// Lists every kernel of every fablet for every instruction set, the slowest to compile first. The
/// list points into both arguments.
std::vector<KernelUnit> list_kernels(const std::vector<FabletUnit>& fablets,
                                     const ProgramOptions& options);

/// Takes kernels from the cache and compiles the others, several at once; or returns the fault of
/// the first in list order that has one, whatever the order of the threads.
std::variant<MadeKernels, Fault> make_kernels(const std::vector<KernelUnit>& units,
                                              const ProgramOptions& options);

/// Writes all objects into `folder`, which exists.
std::variant<ProgramObjects, Fault> compile_program(const std::vector<FabletUnit>& fablets,
                                                    const ProgramOptions& options,
                                                    const std::filesystem::path& folder);

/// Runs a program without a shell, with its temporary files in `folder`: a compiler that a signal
/// ends early leaves some. Returns "" on success, else its stderr.
std::string run_tool(const std::vector<std::string>& command, const std::filesystem::path& folder);

}  // namespace openfab::lower
