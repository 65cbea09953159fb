// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The command lines of `openfab`'s commands.

#include <CLI/CLI.hpp>
#include <functional>

#include "base/result.h"

namespace openfab::tools {

/// What a command does.
using Action = std::function<Result<void>()>;

/// Declares the commands, each of which sets `*action` where it is the one given.
void add_commands(CLI::App& app, Action* action);

}  // namespace openfab::tools
