// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "simd/isa.h"

#include <algorithm>

namespace openfab::simd {

namespace {

Isa detect() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") == 0) return Isa::kSse41;
    if (__builtin_cpu_supports("fma") == 0) return Isa::kAvx2;
    const bool wide =
        __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
        __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
        __builtin_cpu_supports("avx512cd") != 0;
    return wide ? Isa::kAvx512 : Isa::kAvx2Fma;
#else
    return Isa::kSse41;
#endif
}

}  // namespace

Isa best_isa(Isa limit) {
    static const Isa machine = detect();
    return std::min(machine, limit);
}

}  // namespace openfab::simd
