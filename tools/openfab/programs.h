// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds the programs, and print binaries made from fablets.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/input_file.h"
#include "base/result.h"
#include "world/world.h"

namespace openfab::tools {

/// Schedules as `openflc` takes them: files or folders of `--schedule`, and values of `--param`.
struct ScheduleArguments {
    std::vector<std::string> paths, params;
};

/// What a print binary is made of.
struct PrintProgram {
    std::vector<std::filesystem::path> sources;  ///< of OpenFL
    openfab_isa isa;
    ScheduleArguments schedules;
    std::optional<world::DitherRef> dither;  ///< the rule of fablets without one
};

/// Lists the sources and schedules, and all modules and schedules beside them, which they may name.
std::vector<std::filesystem::path> inputs_of(const PrintProgram& program);

/// A print binary whose hash was verified.
struct PrintBinary {
    InputFile file;
    std::filesystem::path path;  ///< in the cache; empty where it was already deleted
};

/// Runs a program to its end with our stderr, and stdout on stderr; returns its exit status, or an
/// error if it cannot start or is ended by a signal.
Result<int> run_program(const std::vector<std::string>& arguments, bool tells_interruption = false);

/// Returns the print binary, compiled unless the cache has it. Its name there is a hash of all its
/// inputs: the sources and modules beside them, the set, schedules and the files beside them, the
/// standard library, openflc, and the libraries it links; it ends in a hash of itself, so that a
/// damaged one is rebuilt. Compile errors are printed by openflc; the error then has an empty
/// message.
Result<PrintBinary> find_or_build_print_binary(const PrintProgram& wanted, bool quiet);

}  // namespace openfab::tools
