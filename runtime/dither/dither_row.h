// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dithers voxel rows, 8 slices at a time as the 8 lanes of a vector. Plain code for any number of
// materials, compiled for each instruction set: generated code, with a buffer per material, reached
// 17 M voxels/s a core for 15 materials where this reaches more than 100, and took half a minute to
// compile for 24. The twins in tests/support/reference define the result to the bit.

#include <cstddef>
#include <cstdint>

#include "abi/fablet_table.h"
#include "runtime/dither/dither_rule.h"

namespace openfab::dither {

/// Slices of a slab; values in memory are [material][slice].
constexpr int32_t kSlices = 8;

/// Margin in voxels on both sides of every row of mixed bits and errors, so that neighbours
/// need no test.
constexpr int32_t kRowMargin = 8;

/// One voxel row of a run of adjacent blocks.
struct DitherRow {
    const uint16_t* fractions = nullptr;  ///< columns (z 8, m), dense
    const int32_t* columns = nullptr;     ///< at first_x: that of each column with a mixed voxel
    int32_t blocks = 0;
    const uint8_t* above = nullptr;  ///< mixed bits at first_x of the rows y - 1, y, y + 1; one
                                     ///< more is read on each side
    const uint8_t* here = nullptr;
    const uint8_t* below = nullptr;
    int32_t first_x = 0;
    int32_t y = 0;
    int32_t z = 0;             ///< lowest slice
    uint8_t* codes = nullptr;  ///< (z 8, x) at first_x; mixed voxels are written, others stay
};

struct DitherSetup {
    DitherRule rule = kDefaultDither;
    openfab_isa isa = OPENFAB_ISA_SSE41;  ///< one that this machine has
    uint32_t seed = 0;                    ///< fold_seed of voxel_hash.h
    int32_t channels = 0;                 ///< materials and void, at most 255
    int32_t width = 0;                    ///< width of the grid in whole blocks, voxels
};

/// Returns how many channels the fractions of a print of `materials` materials have: those and void,
/// and some that are 0 where the dither has code of its own for a little more.
int32_t fraction_channels(int32_t materials);

/// Returns the number of floats that dither_rows keeps between rows: two rows of width + 2
/// kRowMargin voxels, (z 8, m, x, p 2), at p = y & 1 those that row y passes on.
size_t error_count(const DitherSetup& setup);

/// Chooses a material in the mixed voxels of some rows of one run, y by y. Rows come in ascending
/// y; `errors` has error_count() finite floats and is only used by rules that diffuse errors.
void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors);

// The same for one instruction set each; count > 0.
namespace avx2 {
void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors);
}
namespace sse41 {
void dither_rows(const DitherSetup& setup, const DitherRow* rows, int32_t count, float* errors);
}

}  // namespace openfab::dither
