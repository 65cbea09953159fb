// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Names the instruction set that a translation unit is compiled for, which its flags decide.
// Everything that is compiled for several sets is in a namespace of that name, so that the linker
// cannot give an inline function of one set to the code of another.

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__) && defined(__FMA__)
#define OPENFAB_SIMD_ISA avx512
#elif defined(__AVX2__) && defined(__FMA__)
#define OPENFAB_SIMD_ISA avx2_fma
#elif defined(__AVX2__)
#define OPENFAB_SIMD_ISA avx2
#elif defined(__SSE4_1__) || defined(__aarch64__)
#define OPENFAB_SIMD_ISA sse41
#else
#error "this file is compiled for SSE4.1 or more only: give its translation unit the flags of a set"
#endif

#define OPENFAB_INLINE inline __attribute__((always_inline))
/// Attribute of lambdas, between their parameters and their bodies.
#define OPENFAB_INLINE_LAMBDA __attribute__((always_inline))
