// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the programs are, and print programs made from fablets.

#include <filesystem>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tool {

/// The folder of the running program.
Result<std::filesystem::path> program_folder();

/// A print program that was found whole.
struct PrintProgram {
    InputFile file;
    std::filesystem::path path;  ///< in the cache; empty where it is in no folder any more
};

/// The print program of these OpenFL sources, compiled unless the cache has it. Its name there is a
/// hash of everything that it is made of: the sources and modules beside them, the standard
/// library, openflc, and the libraries it links; its end a hash of itself, so that one that is
/// damaged is made again. Compile errors are printed by openflc; the error then has an empty
/// message.
Result<PrintProgram> print_program(const std::vector<std::filesystem::path>& sources, bool quiet);

}  // namespace openfab::tool
