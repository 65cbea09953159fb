// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Limits of a program, which bound the time and memory of a compilation.

#include <cstddef>

namespace openfab::check {

/// Limits of the iterations of a loop, and of an unrolled one.
constexpr int kMaxTrips = 1 << 20;
constexpr int kMaxUnrolledTrips = 256;
/// Limits of the operations of one stage, where an access to a large array counts as a step
/// (Emitter::operations_by_steps) and where it counts as the choices that it is so far
/// (Emitter::operations), and of its statements and calls once loops are unrolled and functions
/// inlined.
constexpr size_t kMaxOperations = 60000;
constexpr size_t kMaxChoices = 400000;
constexpr size_t kMaxSteps = 500000;
/// Limits of the statements and calls that are spent on unrolling one loop, about a tenth of a
/// second, before it becomes a real one. In a constant it may take longer, since there a real loop
/// is one that each voxel runs.
constexpr size_t kMaxUnrolledSteps = 40000;
constexpr size_t kMaxUnrolledStepsOfConstant = 300000;
/// Limit of the textures that a varying index may select from.
constexpr size_t kMaxTextures = 64;

}  // namespace openfab::check
