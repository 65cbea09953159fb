// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The columns of the table: every feature of a world and every tool.

#include <span>
#include <string>
#include <vector>

#include "tests/crossings/bench.h"

namespace openfab::testing {

struct Column {
    std::string id;
    std::string what;  ///< as the page says it
    Change change{};
    /// Makes what is compared. Columns without one print the world, and compare voxels.
    Made (*make)(const Bench& bench) = nullptr;
    /// What it shows works: commands, formats and options (with dashes).
    std::vector<std::string> shows{};
};

std::span<const Column> columns();

/// Commands, formats and options that no column shows, as geometry has no part in them, and why.
struct Elsewhere {
    const char* name;
    const char* why;
};
std::span<const Elsewhere> elsewhere();

// Columns of several files.
std::vector<Column> placement_columns();
std::vector<Column> process_columns();
std::vector<Column> output_columns();
std::vector<Column> tool_columns();
std::vector<Column> mechanics_columns();
std::vector<Column> view_columns();

}  // namespace openfab::testing
