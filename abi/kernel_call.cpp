// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/kernel_call.h"

#include "simd/isa.h"

namespace openfab::abi {

openfab_isa best_isa(openfab_isa limit) {
    const bool wide = limit >= OPENFAB_ISA_AVX2 && simd::best_isa() >= simd::Isa::kAvx2;
    return wide ? OPENFAB_ISA_AVX2 : OPENFAB_ISA_SSE41;
}

}  // namespace openfab::abi
