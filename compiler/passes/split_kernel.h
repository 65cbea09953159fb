// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiling a kernel takes a time that grows with the square of its operations, and of its outputs:
// 1,000 operations take about a second, 4,000 a quarter of a minute. A long kernel of phases is
// therefore cut in pieces that run one after the other, which find in states what earlier ones
// computed. What is computed does not change.

#include <cstddef>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// A kernel of more operations is cut, or one of more than 64 outputs.
constexpr size_t kLongestKernel = 3500;

/// Operations of a stage, by how long compiling takes: a look-up counts for many.
size_t kernel_operations(const ir::Stage& stage);

/// True where a kernel of this stage would be too long.
bool needs_splitting(const ir::Stage& stage, size_t longest = kLongestKernel);

/// `kernel` is straight-line code of kind kSurfacePhase or kVolumePhase. Of the pieces, none reads
/// a state that one before it writes, but those that are appended to `states` for what crosses a
/// cut. A piece has a fifth of the `longest` kernel's operations, or up to two.
std::vector<ir::Stage> split_kernel(const ir::Stage& kernel, std::vector<ir::Type>* states,
                                    size_t longest = kLongestKernel);

}  // namespace openfab::passes
