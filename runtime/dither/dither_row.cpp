// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/dither_row.h"

namespace openfab::dither {

size_t error_count(const DitherSetup& setup) {
    if (setup.rule != DitherRule::kFloydSteinberg && setup.rule != DitherRule::kDecorrelated)
        return 0;
    return 2 * static_cast<size_t>(setup.width + 2 * kRowMargin) *
           static_cast<size_t>(setup.channels * kSlices);
}

void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors) {
    if (count <= 0) return;
    (setup.isa == OPENFAB_ISA_AVX2 ? avx2::dither_rows : sse41::dither_rows)(setup, rows, count,
                                                                             errors);
}

}  // namespace openfab::dither
