// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/solver/rows.h"

#include "simd/isa.h"

namespace openfab::mechanics {

namespace sse41 {
extern const RowKernels kRowKernels;
}
namespace avx2 {
extern const RowKernels kRowKernels;
}
namespace avx512 {
extern const RowKernels kRowKernels;
}

const RowKernels& row_kernels([[maybe_unused]] int limit) {
    if constexpr (simd::kWiderSets) {
        const simd::Isa best = simd::best_isa();
        if (limit >= 2 && best == simd::Isa::kAvx512) return avx512::kRowKernels;
        if (limit >= 1 && best >= simd::Isa::kAvx2) return avx2::kRowKernels;
    }
    return sse41::kRowKernels;
}

}  // namespace openfab::mechanics
