// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls of the fixed-function kernels (abi/stage_table.h). One object per thread: it holds the
// argument arrays.

#include <cstdint>
#include <vector>

#include "runtime/abi/kernel_call.h"
#include "runtime/abi/stage_table.h"
#include "runtime/slab/dither_rule.h"

namespace openfab::slab {

/// Voxels along the margin on both sides of every row of mixed bits and errors, so that neighbours
/// need no test.
constexpr int32_t kRowMargin = 8;

/// Bits of a packed voxel that can be one of `materials` materials or void: 4 or 8.
constexpr int32_t voxel_bits(int32_t materials) {
    return materials > OPENFAB_MAX_MATERIALS_4BIT ? 8 : 4;
}

/// The smallest set for at least `materials` materials, or null beyond OPENFAB_MAX_MATERIALS.
const openfab_stage_set* find_stage_set(int32_t materials);

/// One voxel row of a run of adjacent blocks.
struct DitherRow {
    const uint16_t* fractions = nullptr;  ///< tiles (z 8, m, x 8, y 8), dense
    int32_t tile_count = 0;
    const int32_t* tiles = nullptr;  ///< tile of each block of the run
    int32_t blocks = 0;
    const uint8_t* above = nullptr;  ///< mixed bits at first_x of the rows y - 1, y, y + 1; one
                                     ///< more is read on each side
    const uint8_t* here = nullptr;
    const uint8_t* below = nullptr;
    int32_t first_x = 0;
    int32_t y = 0;
    int32_t z = 0;
    uint8_t* codes = nullptr;  ///< (z 8, x) at first_x
};

class StageCalls {
  public:
    /// The dither is of no matter where only normalise() is called.
    StageCalls(const openfab_stage_set& set, openfab_isa isa, DitherRule rule, uint64_t seed);

    /// Materials of the set; fractions and errors have one more channel.
    int32_t materials() const { return set_.materials; }
    int32_t channels() const { return set_.materials + 1; }
    int32_t tile_values() const { return 512 * channels(); }

    /// `weights`: n blocks of `slots` x 512 floats; `owned`: 64 bytes a block; `fractions`:
    /// tile_values() a block; `codes`: 512 a block; `unusable`: 8 a block. All calls return 0 or
    /// Halide's error code.
    int normalise(const float* weights, int32_t slots, const int32_t* slot_material,
                  const uint8_t* owned, int32_t n, uint16_t* fractions, uint8_t* codes,
                  int32_t* unusable);

    /// Chooses in the mixed voxels of a row, which follows the one above it where that has any.
    /// `errors`, for rules that diffuse them: two rows of `width` + 2 kRowMargin voxels, (z 8, m,
    /// x, p 2); width is that of the grid in whole blocks.
    int dither(const DitherRow& row, float* errors, int32_t width);

    /// `codes` (z 8, x 8 / bits * bytes, y rows) with rows `code_stride` bytes apart; `planes`
    /// likewise.
    int pack(int32_t bits, const uint8_t* codes, int64_t code_stride, int32_t bytes, int32_t rows,
             uint8_t* planes, int64_t row_stride, int64_t plane_stride);

  private:
    int diffuse(openfab_kernel_fn kernel, const DitherRow& row, float* errors, int32_t width);

    const openfab_stage_set& set_;
    openfab_isa isa_;
    DitherRule rule_;
    uint32_t seed_;
    std::vector<abi::KernelBuffer> error_buffers_;
};

}  // namespace openfab::slab
