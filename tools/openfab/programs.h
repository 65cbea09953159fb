// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the programs and the cache are, and print binaries made from fablets.

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/base/result.h"

namespace openfab::tool {

/// The folder of the running program.
Result<std::filesystem::path> program_folder();

/// The print binary of these OpenFL sources, compiled unless the cache has it. Its name there is a
/// hash of everything that it is made of: the sources and modules beside them, the standard
/// library, openflc, and the libraries it links. Compile errors are printed by openflc; the error
/// then has an empty message.
Result<std::filesystem::path> print_binary(const std::vector<std::filesystem::path>& sources,
                                           bool quiet);

}  // namespace openfab::tool
