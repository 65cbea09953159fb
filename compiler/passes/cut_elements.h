// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// An element of an array that a varying index names is, in straight-line code, a choice among all
// elements, and what a loop carries from trip to trip are as many states. Kernels of that take a time
// to compile that grows with the array, and at run time each read and write passes all of it. Where a
// kernel has many such states, elements that differ in nothing but their number are found in it, and
// the runtime moves them by steps of their own: it loads or stores the one that an index names, fills
// or copies an array. The kernel is left with the indices, values and conditions of those steps.

#include <vector>

#include "compiler/ir/ir.h"

namespace openfab::passes {

/// A kernel, which may be without outputs, and the steps after it, in order.
struct ElementPart {
    ir::Stage kernel;
    std::vector<openfab_elements> steps;
};

/// Cuts a kernel of segments: straight-line code that reads states before any output is written.
/// The parts together write what it writes. Values that they pass on get states, which are appended.
/// One part with the kernel itself where nothing is to be found. Outputs that are no states are in
/// the last part.
std::vector<ElementPart> cut_elements(const ir::Stage& kernel, std::vector<ir::Type>* states);

}  // namespace openfab::passes
