// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vectors of floats, integers and masks, one type for each number of lanes, for code that is
// compiled once for each instruction set (target.h). Only correctly rounded IEEE 754 operations are
// here, so that all sets give the same bits: no reciprocal estimates; and FMA, where the set has
// it, only under names that say that it is for pruning.
//
//   Floats4, 8, 16   float      + - * / += -=, < <= == > >=, min max sqrt floor ceil absolute
//   Ints4, 8, 16     int32_t    + - * & >> += -=, < == >, min max; arithmetic wraps
//   Uints4, 8        uint32_t   * ^ >>; arithmetic wraps
//   Mask4, 8, 16     of comparisons: & |, andnot bits any, select masked
//   Fixed16          16 lanes of int16_t, fixed point (fixed.h)
//
//   min(a, b): a < b ? a : b; max(a, b): a > b ? a : b. Both give b where either is NaN.
//   andnot(a, b): ~a & b. select(mask, a, b): mask ? a : b. masked(mask, a): mask ? a : 0.
//   load, store: memory is aligned like the vector; load_unaligned, store_unaligned: it need not.
//   bits(mask): bit l for lane l; Mask::from_bits(bits): the inverse.
//   to_ints: towards 0. round_to_ints: to nearest, ties to even.
//   about_mul_add, about_mul_sub: a b + c and a b - c, rounded once or twice: for pruning tests,
//   which allow for either, never for an answer.
//
// Eight lanes exist for every set: two registers where it has four lanes.
//
// Why not Highway (1.0.3, that of Debian 12): its vectors are never longer than a register, and the
// eight lanes of packets and of the corners of a box, which are two registers of SSE4.1, would need
// these pairs anyway. (FixedTag<float, 8> does not compile for SSE4.1: "Too many lanes".) And its
// targets are not ours: flags of AVX2 without FMA, F16C and BMI2, or of SSE4.1 without AES, select
// its code for SSSE3.

#include "simd/target.h"
#include "simd/vectors_avx2.h"
#include "simd/vectors_avx512.h"
#include "simd/vectors_sse41.h"

namespace openfab::simd {
inline namespace OPENFAB_SIMD_ISA {

// The number of lanes of an SSE4.1 or AVX2 register.
#if defined(__AVX2__)
using Floats = Floats8;
using Ints = Ints8;
using Uints = Uints8;
using Mask = Mask8;
#else
using Floats = Floats4;
using Ints = Ints4;
using Uints = Uints4;
using Mask = Mask4;
#endif
constexpr int kLanes = Floats::kLanes;

// The fastest number of lanes, for code that works with any number from eight.
#if defined(__AVX512F__)
using WidestFloats = Floats16;
#else
using WidestFloats = Floats8;
#endif

}  // namespace OPENFAB_SIMD_ISA
}  // namespace openfab::simd
