// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Vertex indices by point and material.

#include <bit>
#include <cstdint>
#include <vector>

#include "backends/boundary/lattice.h"

namespace openfab::boundary {

/// The vertices at the points of a plane. A material has up to 4 at a point; those of a material
/// are numbered consecutively from point to point. Takes a few bits a point, so that the memory for
/// a plane full of points is bounded in advance.
class VertexTable {
  public:
    void begin();
    /// Ends a row of `words` words and begins the next.
    void begin_word();
    /// Adds `count` vertices of a material at bit `bit` of the current word, numbered from `first`
    /// on if they are its first in this word, unless number_word numbers all of it. Bits must be ascending.
    void add(uint8_t code, int32_t bit, int32_t count, uint32_t first);
    /// Numbers the vertices of the current word from `first` on, material after material, and returns the next
    /// number. Calls visit(bit, count) in the order of the numbers.
    template <typename Visit>
    uint32_t number_word(uint32_t first, Visit visit) {
        for (size_t at = begins_.back(); at < entries_.size(); ++at) {
            Entry& entry = entries_[at];
            entry.first = first;
            const uint64_t any = entry.ones | entry.twos | entry.fours;
            for (uint64_t left = any; left != 0; left &= left - 1) {
                const int32_t bit = std::countr_zero(left);
                const auto count =
                    static_cast<uint32_t>((entry.ones >> bit & 1) + 2 * (entry.twos >> bit & 1) +
                                          4 * (entry.fours >> bit & 1));
                visit(bit, count);
                first += count;
            }
        }
        return first;
    }
    /// Returns the index of the first vertex of `code` at bit `bit` of a word; words are counted in
    /// the order of begin_word.
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
