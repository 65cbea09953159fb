// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/near_boxes_kernel.h"

namespace openfab::solid {

void take_cubes_sse41(const NearLattice& lattice, std::span<const NearCube> cubes, size_t close,
                      size_t box, NearBoxes* boxes) {
    OPENFAB_SIMD_ISA::take(lattice, cubes, close, box, boxes);
}

}  // namespace openfab::solid
