// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/kernel_call.h"

#include <algorithm>
#include <iterator>

#include "simd/isa.h"

namespace openfab::abi {

openfab_isa best_isa(openfab_isa limit) {
    const simd::Isa machine = simd::best_isa();
    const openfab_isa best = machine >= simd::Isa::kAvx512 ? OPENFAB_ISA_AVX512
                             : machine >= simd::Isa::kAvx2 ? OPENFAB_ISA_AVX2
                                                           : OPENFAB_ISA_SSE41;
    return std::min(best, limit);
}

std::span<const openfab_isa> isas() {
    static constexpr openfab_isa kAll[] = {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512};
    return std::span(kAll).first(simd::kWiderSets ? std::size(kAll) : 1);
}

const char* isa_name(openfab_isa isa) {
    return isa == OPENFAB_ISA_AVX512 ? "avx512" : isa == OPENFAB_ISA_AVX2 ? "avx2" : "sse41";
}

const char* isa_title(openfab_isa isa) {
    return isa == OPENFAB_ISA_AVX512 ? "AVX-512"
           : isa == OPENFAB_ISA_AVX2 ? "AVX2"
           : simd::kWiderSets        ? "SSE4.1"
                                     : "NEON";
}

}  // namespace openfab::abi
