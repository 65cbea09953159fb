// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The options of openflc's commands; main.cpp defines their syntax.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compiler/frontend/frontend.h"

namespace openfab::driver {

/// Options of every command.
struct CommonOptions {
    bool json_diagnostics = false;
};

struct FormatOptions {
    std::vector<std::string> files;  ///< `-` is standard input, whose text goes to standard output
    bool check = false;              ///< write nothing, fail where a file would change
};

/// Schedules in place of the built-in ones.
struct ScheduleOptions {
    std::vector<std::string> paths;   ///< files, or folders of them
    std::vector<std::string> params;  ///< "batch=32"
};

struct BackEndOptions {
    ScheduleOptions schedules;
    std::vector<std::string> disabled;  ///< passes
    std::string dump_after;             ///< pass; empty: none
    bool time_passes = false;
};

/// Options that `build` and `run` share.
struct CompilationOptions {
    std::vector<std::string> files;
    std::string target = "both";  ///< sse41, avx2, avx512, both (of the first two) or all
    int threads = 0;              ///< kernels compiled at once; 0: all cores
    bool time = false;            ///< seconds of each step to stderr
    bool enable_printf = false;   ///< compile `printf` and `assert` in
    std::optional<frontend::DitherRule> dither;  ///< of fablets without one
    /// Uniforms by which the fractions are differentiated; a fablet has those that it declares.
    std::vector<std::string> derivatives;
    BackEndOptions back_end;
};

struct BuildOptions {
    CompilationOptions compilation;
    std::string output;
    std::string compiler = "cc";
    std::string linker;  ///< empty: `c++`, with the quickest linker that it has
};

struct RunOptions {
    CompilationOptions compilation;
    bool watch = false;
    int64_t print_lines = 100;  ///< of each `printf`
};

struct EmitOptions {
    std::string file;
    std::string stage;
    std::string form = "ir";
    std::string fablet;
    std::string target;
    ScheduleOptions schedules;
    bool enable_printf = false;
};

struct PassesOptions {
    std::string file;
    std::string fablet;
    std::string output = "passes.html";
    std::vector<std::string> disabled;  ///< passes
    bool enable_printf = false;
};

}  // namespace openfab::driver
