// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Error messages for command lines in our own words: a misspelt option or command gets the name
// that was probably meant.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "base/result.h"

namespace openfab {

/// Describes why `app` failed to parse; `program` is the command whose --help the message names.
Error command_line_error(const CLI::App& app, const CLI::ParseError& error,
                         const std::string& program);

/// Parses a program's command line and does what it says, or shows what --help asks for; says an error,
/// unless its message is empty because another program has said it. Returns the exit code.
int run_command_line(CLI::App* app, int argc, const char* const* argv, const std::string& program,
                     const std::function<Result<void>()>& run);

/// Puts examples, a line each, below the help of a program, and below that of each of its commands those that call it:
/// of a program with commands once all are added.
void add_examples(CLI::App* app, const std::string& examples);

}  // namespace openfab
