// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/inspection/spread.h"

#include "simd/isa.h"

namespace openfab::inspection {

namespace sse41 {
extern const SpreadKernels kSpreadKernels;
}
namespace avx2 {
extern const SpreadKernels kSpreadKernels;
}

const SpreadKernels& spread_kernels([[maybe_unused]] int limit) {
    if constexpr (simd::kWiderSets) {
        if (limit >= 1 && simd::best_isa() >= simd::Isa::kAvx2) return avx2::kSpreadKernels;
    }
    return sse41::kSpreadKernels;
}

}  // namespace openfab::inspection
