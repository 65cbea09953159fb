// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The subcommands of openflc. Each add_ function declares one on the command line; when it is the
// one that was given it sets `*action`, which main then runs and whose result is the exit code
// (0 done, 1 the user's input is wrong, 2 usage, 3 the outside world, 4 a bug). Results go to
// stdout, everything for a person to stderr.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "base/result.h"
#include "compiler/diag/sink.h"
#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

using Action = std::function<int()>;

constexpr int kExitDone = 0;
constexpr int kExitUserInput = exit_code(ErrorCode::kUserInput);
constexpr int kExitUsage = exit_code(ErrorCode::kUsage);
constexpr int kExitOutside = exit_code(ErrorCode::kOutside);
constexpr int kExitBug = exit_code(ErrorCode::kInternal);

/// The exit code for a source that cannot be read: a folder, or what is larger than a source may be,
/// is the user's mistake, all else the world's failure. (check.cpp)
int unread_exit_code(const std::filesystem::path& file);

/// What every command takes.
struct CommonOptions {
    bool json_diagnostics = false;
};

void add_check(CLI::App& app, const CommonOptions& common, Action* action);
void add_describe(CLI::App& app, const CommonOptions& common, Action* action);
void add_emit(CLI::App& app, const CommonOptions& common, Action* action);
void add_build(CLI::App& app, const CommonOptions& common, Action* action);  // build.cpp
void add_run(CLI::App& app, const CommonOptions& common, Action* action);    // run.cpp

/// `emit --as ir|halide|stmt|llvm|asm` of one stage, as the passes leave it, of one fablet, to
/// stdout; exit code. (emit_halide.cpp)
int emit_lowered(const ir::Fablet& fablet, ir::StageKind stage, const std::string& form);

/// Says `openflc: error: what` and returns the code, which says whose fault it is.
int fail(const std::string& what, int code);

/// Prints what a sink holds to stderr in the form that was asked for.
void print_diagnostics(const diag::Sink& sink, const source::SourceManager& sources,
                       const CommonOptions& common);

}  // namespace openfab::driver
