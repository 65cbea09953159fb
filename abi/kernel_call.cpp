// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/kernel_call.h"

namespace openfab::abi {

openfab_isa best_isa(openfab_isa limit) {
    __builtin_cpu_init();
    if (limit >= OPENFAB_ISA_AVX2 && __builtin_cpu_supports("avx2")) return OPENFAB_ISA_AVX2;
    return OPENFAB_ISA_SSE41;
}

}  // namespace openfab::abi
