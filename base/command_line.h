// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Error messages for command lines in our own words: a misspelt option or command gets the name
// that was probably meant.

#include <CLI/CLI.hpp>

#include "base/result.h"

namespace openfab {

/// Describes why `app` failed to parse; `program` is the command whose --help the message names.
Error command_line_error(const CLI::App& app, const CLI::ParseError& error,
                         const std::string& program);

}  // namespace openfab
