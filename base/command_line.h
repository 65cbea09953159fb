// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is wrong with a command line, in words of ours: options and commands that are misspelt get
// the name that was meant.

#include <CLI/CLI.hpp>

#include "base/result.h"

namespace openfab {

/// `app` has failed to parse; `program` is what its --help is asked of.
Error command_line_error(const CLI::App& app, const CLI::ParseError& error,
                         const std::string& program);

}  // namespace openfab
