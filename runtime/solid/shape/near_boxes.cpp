// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/near_boxes.h"

#include "simd/isa.h"

namespace openfab::solid {

NearKernels near_kernels() {
    if constexpr (simd::kWiderSets) {
        if (simd::best_isa(simd::Isa::kAvx2) >= simd::Isa::kAvx2) return near_kernels_avx2();
    }
    return near_kernels_sse41();
}

}  // namespace openfab::solid
