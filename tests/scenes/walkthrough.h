// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Follows a page of documentation like a reader: writes the files that it shows and types the
// commands that it gives, in order, in one shell.

#include <string>
#include <vector>

namespace openfab::testing {

struct Walkthrough {
    std::string script;  ///< for bash
    int files = 0;       ///< blocks that are the contents of a file
    int commands = 0;    ///< commands of OpenFab in the text
};

/// A fenced block is a file if the line of text right before it names one in backticks, else it is
/// typed. Commands in backticks in the text are typed, too; those that end on request are ended.
Walkthrough walkthrough_of(const std::string& markdown);

/// Returns the targets of the pictures that a page shows.
std::vector<std::string> pictures_of(const std::string& markdown);

}  // namespace openfab::testing
