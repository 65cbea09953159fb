// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls the fixed-function kernels (abi/stage_table.h).

#include <cstdint>

#include "abi/kernel_call.h"
#include "abi/stage_table.h"

namespace openfab::abi {

/// Returns the bits of a packed voxel, 4 or 8, for `materials` materials and void.
constexpr int32_t voxel_bits(int32_t materials) {
    return materials > OPENFAB_MAX_MATERIALS_4BIT ? 8 : 4;
}

/// Returns the smallest set for at least `materials` materials, or null beyond
/// OPENFAB_MAX_MATERIALS.
const openfab_stage_set* find_stage_set(int32_t materials);

class StageCalls {
  public:
    StageCalls(const openfab_stage_set& set, openfab_isa isa) : set_(set), isa_(isa) {}

    /// Returns the number of materials of the set; fractions have one more channel.
    int32_t materials() const { return set_.materials; }
    int32_t channels() const { return set_.materials + 1; }
    int32_t tile_values() const { return 512 * channels(); }

    /// Normalises `weights`: n blocks of `slots` x 512 floats; `owned`: 64 bytes a block;
    /// `fractions`: tile_values() a block; `codes`: 512 a block; `unusable`: 8 a block.
    abi::KernelStatus normalise(const float* weights, int32_t slots, const int32_t* slot_material,
                                const uint8_t* owned, int32_t n, uint16_t* fractions,
                                uint8_t* codes, int32_t* unusable);

    /// Packs `codes` (z 8, x 8 / bits * bytes, y rows) with rows `code_stride` bytes apart;
    /// `planes` likewise.
    abi::KernelStatus pack(int32_t bits, const uint8_t* codes, int64_t code_stride, int32_t bytes,
                           int32_t rows, uint8_t* planes, int64_t row_stride, int64_t plane_stride);

  private:
    const openfab_stage_set& set_;
    openfab_isa isa_;
};

}  // namespace openfab::abi
