// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The commands of openflc. Each returns the exit code: 0 done, 1 the user's input is wrong, 2
// usage, 3 the outside world, 4 a bug. Results go to stdout, messages to stderr.

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "compiler/diag/sink.h"
#include "compiler/driver/options.h"
#include "compiler/ir/ir.h"
#include "compiler/source/source_manager.h"

namespace openfab::driver {

constexpr int kExitDone = 0;
constexpr int kExitUserInput = exit_code(ErrorCode::kUserInput);
constexpr int kExitUsage = exit_code(ErrorCode::kUsage);
constexpr int kExitOutside = exit_code(ErrorCode::kOutside);
constexpr int kExitBug = exit_code(ErrorCode::kInternal);

/// Returns the exit code for a source that cannot be read: a folder or a too large file is the
/// user's mistake, anything else a failure of the outside world.
int unread_exit_code(const std::filesystem::path& file);

/// `check`: reports what is wrong with files; with `derivatives` also where fractions jump.
int check(const std::vector<std::string>& files, bool derivatives, const CommonOptions& common);

/// `fmt`: lays files out in one style, or with `check` says which are not. (format.cpp)
int format_files(const FormatOptions& options, const CommonOptions& common);

/// `lsp`: serves an editor over standard input and output. (compiler/driver/serve.cpp)
int serve_editor();

/// `describe`: prints the interface of a file's fablets as JSON. (describe.cpp)
int describe_file(const std::string& file, const CommonOptions& common);

/// `emit`: prints a stage in one of the compiler's forms. (emit.cpp)
int emit(const EmitOptions& options, const CommonOptions& common);

/// `passes`: writes a page with the IR of a fablet after each pass. (passes.cpp)
int show_passes(const PassesOptions& options, const CommonOptions& common);

/// `build`: writes a print program. (build.cpp)
int build(const BuildOptions& options, const CommonOptions& common);

/// `run`: compiles in memory and prints. `words` are the arguments that openflc does not know:
/// OpenFL files, and the command line of the print. (run.cpp)
int run(RunOptions options, const CommonOptions& common, const std::vector<std::string>& words);

/// Runs `emit --as ir|halide|schedule|loops|stmt|llvm|asm` for one stage of a fablet after the
/// passes, to stdout. Returns an exit code. (emit_halide.cpp)
int emit_lowered(const ir::Fablet& fablet, ir::StageKind stage, const EmitOptions& options,
                 source::SourceManager* sources, const CommonOptions& common);

/// Prints `openflc: error: what` and returns `code`.
int fail(const std::string& what, int code);

/// Prints the diagnostics of a sink to stderr, as text or JSON.
void print_diagnostics(const diag::Sink& sink, const source::SourceManager& sources,
                       const CommonOptions& common);

}  // namespace openfab::driver
