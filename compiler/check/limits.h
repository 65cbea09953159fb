// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Limits of a program, which bound the time and memory of a compilation.

#include <cstddef>

namespace openfab::check {

/// The most iterations of a loop, and of one that is unrolled.
constexpr int kMaxTrips = 1 << 20;
constexpr int kMaxUnrolledTrips = 256;
/// The most operations of one stage (Emitter::operations), and below, the most statements and calls
/// once loops are unrolled and functions inlined.
constexpr size_t kMaxOperations = 60000;
/// The most textures that a varying index may choose from.
constexpr size_t kMaxTextures = 64;
constexpr size_t kMaxSteps = 500000;

}  // namespace openfab::check
