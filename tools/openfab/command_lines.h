// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The command lines of `openfab`'s commands.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab::tools {

/// What a command does.
using Action = std::function<Result<void>()>;

/// Declares the commands, each of which sets `*action` where it is the one given.
void add_commands(CLI::App& app, Action* action);
/// Declares those for parts before they are printed.
void add_part_commands(CLI::App& app, Action* action);
/// Declares `specimens make` and `specimens read`.
void add_specimens(CLI::App& app, Action* action);

// Options of several commands.

void add_memory_option(CLI::App* command, std::string* text);
void add_set_option(CLI::App* command, std::vector<std::string>* settings);
/// Declares what says how a world is read, as for its print.
void add_world_options(CLI::App* command, std::vector<std::string>* allow,
                       std::vector<std::string>* settings);

}  // namespace openfab::tools
