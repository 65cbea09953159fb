// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The instruction set of this machine, from which all code that is compiled more than once takes
// its choice. For plain translation units, unlike the rest of this folder.

namespace openfab::simd {

/// Instruction sets that code is compiled for; each set holds those before it. SSE4.1 is required.
/// kAvx512 stands for AVX-512 F, VL and DQ.
enum class Isa { kSse41, kAvx2, kAvx2Fma, kAvx512 };

/// Returns the best set that this machine has and `limit` allows. Detects it once.
Isa best_isa(Isa limit = Isa::kAvx512);

}  // namespace openfab::simd
