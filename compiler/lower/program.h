// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiles fablets to object files: kernels in parallel threads, and the C table that names them.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "compiler/lower/compile.h"
#include "compiler/lower/table.h"

namespace openfab::lower {

/// Schedules in place of the default ones, by pipeline ("volume") and instruction set.
using ScheduleSet = std::map<std::pair<std::string, openfab_isa>, Schedule>;

struct ProgramOptions {
    std::vector<openfab_isa> isas = {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2};
    ScheduleSet schedules;
    int threads = 0;              ///< 0: all cores
    std::string compiler = "cc";  ///< C compiler for the table, and linker
};

struct ProgramTimes {
    double kernels = 0;  ///< seconds on the clock
    double table = 0;
};

struct ProgramObjects {
    std::vector<std::filesystem::path> objects;  ///< kernels, then the table
    ProgramTimes times;
};

/// Calls `compile` for each kernel, `threads` at once (0: all cores); returns the fault of
/// the first kernel in the list that has one, whichever thread met it.
std::optional<Fault> compile_each(const std::vector<KernelUnit>& units, int threads,
                                  const std::function<std::optional<Fault>(size_t unit)>& compile);

/// Returns the request that compiles a kernel of the program; it points into both.
KernelRequest request_of(const KernelUnit& unit, const ProgramOptions& options);

/// Writes all objects into `folder`, which exists.
std::variant<ProgramObjects, Fault> compile_program(const std::vector<FabletUnit>& fablets,
                                                    const ProgramOptions& options,
                                                    const std::filesystem::path& folder);

/// Runs a program without a shell. Returns "" on success, else what it wrote to stderr.
std::string run_tool(const std::vector<std::string>& command);

}  // namespace openfab::lower
