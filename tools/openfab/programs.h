// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Finds the programs, and print binaries made from fablets.

#include <filesystem>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// Returns the folder of the running program.
Result<std::filesystem::path> program_folder();

/// A print binary whose hash was verified.
struct PrintBinary {
    InputFile file;
    std::filesystem::path path;  ///< in the cache; empty where it was already deleted
};

/// Returns the print binary of these OpenFL sources for one instruction set, compiled unless the
/// cache has it. Its name there is a hash of all its inputs: the sources and modules beside them,
/// the set, the standard library, openflc, and the libraries it links; it ends in a hash of itself,
/// so that a damaged one is rebuilt. Compile errors are printed by openflc; the error then has an
/// empty message.
Result<PrintBinary> find_or_build_print_binary(const std::vector<std::filesystem::path>& sources,
                                               openfab_isa isa, bool quiet);

}  // namespace openfab::tools
