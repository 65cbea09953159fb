// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "abi/kernel_call.h"

namespace openfab::testing {

/// The instruction sets that tests compile for: all that the machine has, but one under sanitizers, which slow Halide
/// down several times and do not instrument the code that it generates.
inline std::vector<openfab_isa> tested_isas() {
#ifdef OPENFAB_SANITIZED
    return {OPENFAB_ISA_SSE41};
#else
    std::vector<openfab_isa> out = {OPENFAB_ISA_SSE41};
    for (const openfab_isa isa : {OPENFAB_ISA_AVX2, OPENFAB_ISA_AVX512}) {
        if (abi::best_isa(isa) == isa) out.push_back(isa);
    }
    return out;
#endif
}

}  // namespace openfab::testing
