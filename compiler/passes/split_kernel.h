// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Compiling a kernel takes a time that grows faster than the states that it reads and writes, and
// memory and stack that grow with its operations. A long segment is therefore split into pieces that
// run one after the other and pass values through states. Results do not change.

#include <cstddef>
#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// A kernel of more operations is split, or one of more than 64 outputs or 96 states that it reads.
constexpr size_t kMaxKernelOperations = 3500;
/// The same for a stage that is cut into segments anyhow: a few more cost little at run time.
constexpr size_t kMaxSegmentOperations = 1500;

/// Returns the operations of a stage, weighted by compile time: a lookup counts as many.
size_t kernel_operations(const ir::Stage& stage);

/// Returns the first instruction up to which a stage has more than this many of them, or kNoValue.
ir::ValueId first_beyond(const ir::Stage& stage, size_t operations);

/// True of a kernel that passes many values on, such as the elements of an array.
bool is_wide(const ir::Stage& kernel);

/// True if a kernel of this stage would be too long.
bool needs_splitting(const ir::Stage& stage, size_t longest = kMaxKernelOperations);

/// Splits straight-line code of kind kSurfaceSegment or kVolumeSegment. No piece reads a state that
/// an earlier one writes, except those appended to `states` for values that cross a split. A piece
/// has one to two fifths of the operations of the `longest` kernel.
std::vector<ir::Stage> split_kernel(const ir::Stage& kernel, std::vector<ir::Type>* states,
                                    size_t longest = kMaxKernelOperations);

}  // namespace openfab::passes
