// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What commands have in common whose words are those of a print, and which compile it into their own process.

#include <CLI/CLI.hpp>
#include <string>

#include "compiler/driver/schedules.h"

namespace openfab::tuner {

/// Adds examples and the print's own options to the help of a command, and lets it take them.
void take_print_options(CLI::App* command, const std::string& program, const std::string& examples);

void add_schedule_options(CLI::App* command, driver::ScheduleOptions* options);

}  // namespace openfab::tuner
