// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The highest slice of each column of a print, as a picture.

#include <cstdint>
#include <span>
#include <vector>

namespace openfab::gcvf {

class HeightMap {
  public:
    HeightMap(int32_t width, int32_t height);
    /// Adds slice `z`, counted from 0, as solid bits; slices come in rising order.
    void add(uint16_t z, std::span<const uint8_t> solid);
    /// Returns a PNG of 16-bit grey: the number of the highest slice in which the column is solid, 0
    /// also where it is in none. The top row is the largest y; `flip_x`: +x points left. Empty where
    /// memory ran out.
    std::vector<uint8_t> png(bool flip_x) const;

  private:
    int32_t width_, height_;
    std::vector<uint16_t> tops_;  ///< rows padded to whole bytes of solid bits
};

}  // namespace openfab::gcvf
