// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Two prints of one grid, voxel by voxel. Materials are the same where their names are.

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/pipeline/slice_sink.h"
#include "tools/viewer/tile.h"

namespace openfab::viewer {

/// The code of voxels that differ.
constexpr uint8_t kDifferent = 255;

class Difference {
  public:
    /// For rows of `width` voxels.
    Difference(const pipeline::PrintInfo& first, const pipeline::PrintInfo& second, int32_t width);

    /// Returns the codes, one a byte, of two packed rows where they are equal, and kDifferent where
    /// they are not; valid until the next call. Null where both are; one alone differs from void.
    const uint8_t* row(const uint8_t* first, const uint8_t* second);
    /// Returns the code that the first print has for a code of the second, or one that it never has.
    uint8_t as_first(uint8_t code) const { return as_first_[code]; }
    /// Makes what is equal pale and what differs stand out.
    static void fade(Palette* palette);
    /// Same for a volume: what is equal hides about half of what lies behind `across_mm` of it.
    static void fade_through(Palette* palette, double across_mm);

  private:
    int32_t first_bits_, second_bits_;
    std::array<uint8_t, 256> as_first_{};
    std::vector<uint8_t> codes_, others_, nothing_;
};

}  // namespace openfab::viewer
