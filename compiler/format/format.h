// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lays out OpenFL in one style, that of the standard library. The result depends on the tokens and the comments, and on
// these choices of the author: blank lines (at most one is kept), whether a body of one statement stands on the line of
// its function, which statements stand on the line of a `case` label, and the rows of lists in braces and of
// constructors.

#include <string>

#include "base/result.h"
#include "compiler/diag/sink.h"
#include "compiler/source/source_manager.h"

namespace openfab::format {

/// Lines are broken before this column where they can be; comments and strings are not.
constexpr int kLineWidth = 120;
constexpr int kIndent = 4;

/// Returns a file's text in the one style: the same tokens and comments in the same order, so the same meaning.
/// Formatting the result again gives the same text. A user error if the file has syntax errors, which are in `sink`.
Result<std::string> format(const source::SourceManager& sources, uint32_t file, diag::Sink* sink);

}  // namespace openfab::format
