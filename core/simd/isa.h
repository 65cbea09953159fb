// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Detects the instruction set of this machine, by which all multiversioned code is dispatched. For
// plain translation units, unlike the rest of this folder.

namespace openfab::simd {

#if defined(__x86_64__)
inline constexpr bool kWiderSets = true;
#else
/// Whether code for more than the first set is compiled at all.
inline constexpr bool kWiderSets = false;
#endif

/// Instruction sets that code is compiled for; each set includes those before it. SSE4.1 is
/// required; on arm64 it is NEON under that name (intrinsics.h), and the only one. kAvx512 stands
/// for AVX-512 F, CD, BW, DQ and VL.
enum class Isa { kSse41, kAvx2, kAvx2Fma, kAvx512 };

/// Returns the best set that this machine has and `limit` allows. Detects it once.
Isa best_isa(Isa limit = Isa::kAvx512);

}  // namespace openfab::simd
