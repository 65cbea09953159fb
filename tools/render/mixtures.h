// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Codes of mixtures, for cells of several voxels. Dots of single materials as large as such a cell would leave white
// between them: light that dots of the print's own size absorb would come back, and tones get lighter. So a cell has
// the mean of its voxels, in as many equal parts as 255 codes can tell apart: 254 parts of two materials, 21 of three,
// 3 of eight.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace openfab::render {

class Mixtures {
  public:
    /// Of `materials` of them, 0 to 255. More than 22 have one part a mixture: codes are then materials, from 1.
    explicit Mixtures(int32_t materials);

    /// How many equal parts a mixture has.
    int32_t parts() const { return parts_; }
    /// Returns the code of a mixture whose parts are in the mean the shares of `counts`, by material, of which one is
    /// not 0; at most 2^16 each. `random` decides: each part is off by less than one.
    uint8_t draw(const uint16_t* counts, uint16_t random) const;
    /// Parts by material, of each code; none of code 0.
    const std::vector<std::vector<uint8_t>>& by_code() const { return by_code_; }

  private:
    size_t materials_;
    int32_t parts_;
    /// [left][p]: how many mixtures of p parts there are of the last `left` materials.
    std::vector<std::vector<uint32_t>> ways_;
    std::vector<std::vector<uint8_t>> by_code_;
};

}  // namespace openfab::render
