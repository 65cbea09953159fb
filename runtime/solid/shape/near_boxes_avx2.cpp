// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/near_boxes_kernel.h"

namespace openfab::solid {

NearKernels near_kernels_avx2() {
    return {OPENFAB_SIMD_ISA::take, OPENFAB_SIMD_ISA::add};
}

}  // namespace openfab::solid
