// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/dither_row.h"

#include "simd/isa.h"

namespace openfab::dither {

int32_t fraction_channels(int32_t materials) {
    const int32_t channels = materials + 1;
    for (const int32_t count : {2, 3, 4, 5, 7, 9, 13, 16}) {  // those of diffuse_rows_of
        if (channels <= count) return count;
    }
    return channels;
}

size_t error_count(const DitherSetup& setup) {
    if (setup.rule != DitherRule::kFloydSteinberg && setup.rule != DitherRule::kDecorrelated)
        return 0;
    return 2 * static_cast<size_t>(setup.width + 2 * kRowMargin) *
           static_cast<size_t>(setup.channels * kSlices);
}

void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors) {
    if (count <= 0) return;
    if constexpr (simd::kWiderSets) {
        if (setup.isa >= OPENFAB_ISA_AVX2) {
            avx2::dither_rows(setup, rows, count, errors);
            return;
        }
    }
    sse41::dither_rows(setup, rows, count, errors);
}

}  // namespace openfab::dither
