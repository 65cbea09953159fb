// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets of this folder compiled into this process, and prints in it: a process of its own for each takes ten times as
// long as a small print.

#include <filesystem>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "tests/support/prints/box_print.h"

namespace openfab::testing {

/// Compiles a source of this folder, once; kernels stay in the build's own cache. Fails the test, and returns none, where
/// it does not compile.
const openfab_fablet_list& fablets_of(const std::string& source);

/// Prints with the options that a command line has, the world first.
Result<void> print_here(const openfab_fablet_list& fablets, const std::vector<std::string>& words,
                        MemorySink* sink);

/// An error as programs show it.
std::string shown(const Error& error);

}  // namespace openfab::testing
