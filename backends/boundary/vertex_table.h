// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers of vertices, by point and material.

#include <cstdint>
#include <vector>

#include "backends/boundary/lattice.h"

namespace openfab::boundary {

/// The vertices at the points of a plane. A material has up to 4 at a point; those of a material
/// are numbered on from point to point. Takes a few bits a point, so that a plane full of points
/// needs no more memory than can be told before.
class VertexTable {
  public:
    void begin();
    /// Ends a row of `words` words and begins the next.
    void begin_word();
    /// `count` more vertices of a material at bit `bit` of the word begun last, from `first` on if
    /// they are its first in this word. Bits come in rising order.
    void add(uint8_t code, int32_t bit, int32_t count, uint32_t first);
    /// The number of the first vertex of `code` at bit `bit` of a word, counted in the order they
    /// were begun.
    uint32_t first(size_t word, int32_t bit, uint8_t code) const;

  private:
    struct Entry {
        uint64_t ones = 0, twos = 0, fours = 0;  ///< the counts, bit by bit
        uint32_t first = 0;
        uint8_t code = 0;
    };

    std::vector<uint32_t> begins_;  ///< by word, into entries
    std::vector<Entry> entries_;
};

}  // namespace openfab::boundary
