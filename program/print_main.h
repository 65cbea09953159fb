// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The program that `openflc build` links with a list of fablets: a print binary.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "abi/fablet_table.h"
#include "program/options.h"

namespace openfab::program {

/// Runs one print; `interrupt` ends it early after the slices in flight. `files`, if given,
/// receives the files of the world, also when the print fails later. `began_seconds`: see
/// pipeline::PrintOptions.
Result<void> run_print(const Options& options, const openfab_fablet_list& fablets,
                       const std::atomic<bool>& interrupt,
                       std::vector<std::filesystem::path>* files = nullptr,
                       double began_seconds = 0);

/// Sets how many lines of each printf prints of this process show; 100 unless told.
void keep_print_lines(int64_t most);

/// Reports an error, if any, on stderr and returns the exit code.
int finish(const Result<void>& done, ProgressMode progress = ProgressMode::kAuto);

/// Runs a print from the command line and returns the exit code: 0 done, 1 the input is wrong, 2
/// usage, 3 disk or pipe failed, 4 a bug of ours, 130 interrupted. stdout carries data alone (`-o
/// -`, or the text of --help); the rest goes to stderr.
int print_main(int argc, char** argv, const openfab_fablet_list& fablets);

}  // namespace openfab::program
