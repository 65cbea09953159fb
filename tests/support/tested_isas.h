// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "abi/fablet_table.h"

namespace openfab::testing {

/// The instruction sets that tests compile for: both, but one under sanitizers, which slow Halide
/// down several times and do not instrument the code that it generates.
inline std::vector<openfab_isa> tested_isas() {
#ifdef OPENFAB_SANITIZED
    return {OPENFAB_ISA_SSE41};
#else
    return {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2};
#endif
}

}  // namespace openfab::testing
