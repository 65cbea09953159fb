// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Limits of a program, which keep what a compile takes within bounds.

#include <cstddef>

namespace openfab::sema {

/// Most times that a loop may run, and that one may that is unrolled.
constexpr int kMaxTrips = 1 << 20;
constexpr int kMaxUnrolledTrips = 256;
/// Most operations of one stage (Emitter::operations), and most statements and calls once loops are
/// unrolled and functions inlined.
constexpr size_t kMaxOperations = 60000;
/// Most textures that a varying index may pick one of.
constexpr size_t kMaxTextures = 64;
constexpr size_t kMaxSteps = 500000;

}  // namespace openfab::sema
