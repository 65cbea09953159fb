// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the fractions of a fablet jump when uniforms change: there a derivative is that of one side.

#include <string>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

enum class JumpKind {
    kComparison,  ///< decides between values that differ where it changes
    kRounding,    ///< floor, ceil, round, trunc, or a conversion to a whole number
    kRemainder,   ///< fmod
    kCell,        ///< the number of a cell of `cellular`
    kBorder,      ///< of the part: its shape or its displacement moves, so that voxels come and go
};

struct Jump {
    JumpKind kind = JumpKind::kComparison;
    source::Span span;
    std::vector<std::string> uniforms;  ///< that move it, in the order of their declarations
};

/// Finds the jumps of a volume stage, and the stages that move the part's border, as the front end gives it, by uniforms of floats; each place once, a border at its first read of each uniform. A choice counts
/// as smooth where its two values are those that are compared, or a value and its negative: a `min`, a `max`, an `abs`.
std::vector<Jump> find_jumps(const ir::Fablet& fablet);

}  // namespace openfab::passes
