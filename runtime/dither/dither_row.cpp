// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/dither_row.h"

#include <immintrin.h>

#include <cstring>
#include <limits>

#include "abi/dither_rules.h"
#include "abi/stage_table.h"
#include "abi/voxel_hash.h"
#include "runtime/dither/blue_noise.h"

namespace openfab::dither {

namespace {

/// Slices of a slab; values in memory stand [material][slice].
constexpr int32_t kSlices = 8;
constexpr int32_t kMostChannels = OPENFAB_MAX_MATERIALS + 1;

}  // namespace

}  // namespace openfab::dither

#define OPENFAB_LANES_ISA avx2
#define OPENFAB_LANES_TARGET "avx2"
#define OPENFAB_LANES_AVX2 1
#include "runtime/dither/lanes.inl"
//
#include "runtime/dither/dither_row.inl"
#undef OPENFAB_INLINE_ANYWHERE
#undef OPENFAB_INLINE
#undef OPENFAB_INLINE_LAMBDA
#undef OPENFAB_LANES_ISA
#undef OPENFAB_LANES_TARGET
#undef OPENFAB_LANES_AVX2

#define OPENFAB_LANES_ISA sse41
#define OPENFAB_LANES_TARGET "sse4.1"
#define OPENFAB_LANES_AVX2 0
#include "runtime/dither/lanes.inl"
//
#include "runtime/dither/dither_row.inl"

namespace openfab::dither {

namespace {

// `flatten`: the hashes that they call are inlined, too.
__attribute__((target("avx2"), flatten)) void rows_avx2(const DitherSetup& setup,
                                                        const DitherRow* rows, int32_t count,
                                                        float* errors) {
    avx2::any_rows(setup, rows, count, errors);
}

__attribute__((target("sse4.1"), flatten)) void rows_sse41(const DitherSetup& setup,
                                                           const DitherRow* rows, int32_t count,
                                                           float* errors) {
    sse41::any_rows(setup, rows, count, errors);
}

}  // namespace

size_t error_count(const DitherSetup& setup) {
    if (setup.rule != DitherRule::kFloydSteinberg && setup.rule != DitherRule::kDecorrelated)
        return 0;
    return 2 * static_cast<size_t>(setup.width + 2 * kRowMargin) *
           static_cast<size_t>(setup.channels * kSlices);
}

void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors) {
    if (count <= 0) return;
    (setup.isa == OPENFAB_ISA_AVX2 ? rows_avx2 : rows_sse41)(setup, rows, count, errors);
}

}  // namespace openfab::dither
