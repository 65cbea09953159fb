// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the statements of a block begin and end, by its tokens: the syntax tree keeps no ends.

#include <vector>

#include "compiler/server/analysis.h"

namespace openfab::graph {

/// Tokens of a statement: from `first` to before `end`.
struct Extent {
    size_t first = 0;
    size_t end = 0;
};

/// Returns the statements between two braces, which are tokens; of damaged text as far as it goes.
std::vector<Extent> statements_between(const server::Analysis& analysis, size_t open, size_t close);

/// Returns the byte at which lines may be inserted before a token, above the comments that belong to it: behind what ends
/// the line of the token before.
uint32_t lead_of(const server::Analysis& analysis, size_t token);
/// Returns the end of a token, or of the comment that stands behind it on its line.
uint32_t tail_of(const server::Analysis& analysis, size_t token);

}  // namespace openfab::graph
