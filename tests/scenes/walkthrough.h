// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Follows a page of documentation like a reader: writes the files that it shows and types the
// commands that it gives, in order, in one shell.

#include <string>
#include <vector>

namespace openfab::testing {

/// A fenced block of a page.
struct Block {
    int line = 0;          ///< of its fence
    std::string language;  ///< the first word of the fence
    std::string how;       ///< the words after it: how it is tried
    std::string file;      ///< the file that it is, where the text before it names one
    std::string text;
};

struct Walkthrough {
    std::string script;                 ///< for bash, in the folder where the reader is
    int files = 0;                      ///< blocks that are the contents of a file
    int commands = 0;                   ///< commands of OpenFab in the text
    int blocks = 0;                     ///< blocks that are tried: typed, compiled, checked, run
    std::vector<std::string> by_hand;   ///< blocks that no test can try, as `LINE: REASON`
    std::vector<std::string> mistakes;  ///< blocks whose fence does not say what they hold
};

struct WalkthroughOptions {
    bool whole = true;  ///< with the blocks that are for long runs alone
    std::string
        python;  ///< the interpreter that has the package; empty: blocks of Python are left out
    std::vector<std::string>
        parts;  ///< optional ones that were built; blocks that need others are left out
};

/// A fenced block is a file if the line of text right before it names one in backticks; else its
/// fence says what becomes of it (docs/testing.md lists the words). Commands in backticks in the
/// text are typed, too; those that end on request are ended.
Walkthrough walkthrough_of(const std::string& markdown, const WalkthroughOptions& options = {});

/// Returns all fenced blocks of a page, in order.
std::vector<Block> blocks_of(const std::string& markdown);

/// Returns the targets of the pictures that a page shows.
std::vector<std::string> pictures_of(const std::string& markdown);

}  // namespace openfab::testing
