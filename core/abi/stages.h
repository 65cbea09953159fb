// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Calls the fixed-function kernels (abi/stage_table.h).

#include <cstdint>
#include <span>
#include <vector>

#include "abi/kernel_call.h"
#include "abi/stage_table.h"

namespace openfab::abi {

/// Returns the bits of a packed voxel, 4 or 8, for `materials` materials and void.
constexpr int32_t voxel_bits(int32_t materials) {
    return materials > OPENFAB_MAX_MATERIALS_4BIT ? 8 : 4;
}

/// The channels in which amounts become fractions: channel 0, and one for each slot.
class Channels {
  public:
    Channels() = default;
    /// `slot_material`: the code of each slot's material, 0 void.
    explicit Channels(std::span<const int32_t> slot_material);

    int32_t count() const { return count_; }
    /// Returns the code of the material whose fraction a channel has, or -1 for none.
    int32_t material(int32_t channel) const {
        return table_[static_cast<size_t>(channel * OPENFAB_CHANNEL_ROWS +
                                          OPENFAB_CHANNEL_MATERIAL)];
    }
    /// Returns the table for kernels, (3, count).
    const int32_t* table() const { return table_.data(); }

  private:
    int32_t count_ = 0;
    std::vector<int32_t> table_;
};

/// Normalises columns of amounts: `groups` lists columns of `weights`, whose slots are
/// `slot_stride` floats apart. For the i-th listed one, `fractions` has channels.count() * 8 values,
/// `codes` and `unusable` 8 each.
KernelStatus normalise(openfab_isa isa, std::span<const int32_t> groups, const Channels& channels,
                       const float* weights, int64_t slot_stride, uint16_t* fractions,
                       uint8_t* codes, uint16_t* unusable);

/// Packs `codes` (z 8, x 8 / bits * bytes, y rows) with rows `code_stride` bytes apart; `planes`
/// likewise.
KernelStatus pack(openfab_isa isa, int32_t bits, const uint8_t* codes, int64_t code_stride,
                  int32_t bytes, int32_t rows, uint8_t* planes, int64_t row_stride,
                  int64_t plane_stride);

}  // namespace openfab::abi
