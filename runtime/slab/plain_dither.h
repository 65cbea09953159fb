// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dithers in plain code, 8 slices at a time: the rules that need no neighbours, and error diffusion
// for prints of more materials than kernels are generated for (a kernel for 24 takes half a minute
// to compile). What they compute is stated by their twins in tests/support/reference, which give
// the same bits.

#include <cstdint>

#include "runtime/slab/dither_rule.h"

namespace openfab::slab {

struct DitherRow;

/// kBlueNoise and kMajority. `seed` is the folded one.
void pick_row(DitherRule rule, const DitherRow& row, int32_t channels, uint32_t seed);

/// kFloydSteinberg and kDecorrelated. `errors` as for StageCalls::dither.
void diffuse_row(DitherRule rule, const DitherRow& row, int32_t channels, uint32_t seed,
                 float* errors, int32_t width);

}  // namespace openfab::slab
