// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The commands of `openfab`. Each add_ function declares one; when it is the one that was given, it
// sets `*action`, which main then runs, and whose error, if any, main reports.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "base/result.h"

namespace openfab::tool {

using Action = std::function<Result<void>()>;

void add_new(CLI::App& app, Action* action);
void add_import(CLI::App& app, Action* action);
void add_info(CLI::App& app, Action* action);
void add_verify(CLI::App& app, Action* action);
void add_export(CLI::App& app, Action* action);

/// `openfab print …`: compiles what changed and becomes the print binary; returns the exit code
/// where that fails. It reads the print binary's own options, so it is no CLI11 command.
int print_command(int argc, char** argv);

/// `openfab texture …`: becomes `openfab-texture`, beside this program.
int texture_command(char** argv);

}  // namespace openfab::tool
