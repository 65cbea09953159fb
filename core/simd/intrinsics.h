// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The intrinsics of x86. On arm64 those of SSE4.1 are SIMDe's, which writes each with NEON and keeps its meaning: which
// operand a minimum takes where one is NaN, how a conversion rounds. So one source serves both, and both give the same bits.

#if defined(__x86_64__)
#include <immintrin.h>
#else
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/sse4.1.h>
#endif
