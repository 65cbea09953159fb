// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far the surface is at least, from any place: short flights there need no search for it. A dual cell, between the
// centres of eight voxels, is solid if the coverage of all of them is inside, void if that of none is, else mixed. The
// clearance of a mixed one is 0, that of another 1, with all its neighbours like it 2, with all theirs kMost.

#include <cstdint>
#include <vector>

#include "tools/render/volume.h"

namespace openfab::render {

class Clearances {
  public:
    static constexpr int32_t kMost = 3;
    static constexpr uint32_t kUniform = 0x80000000U;
    static constexpr size_t kBlockBytes = Volume::kBlockVoxels / 2;
    /// Added to the clearance of void dual cells.
    static constexpr int32_t kVoid = 4;

    /// What is at a block's points, with all that interpolation reaches.
    enum class Kind : uint8_t { kOutside, kInside, kSurface };

    Clearances() = default;
    explicit Clearances(const Volume& volume);

    struct Clearance {
        int32_t value;     ///< a clearance, or kVoid and one
        bool is_of_block;  ///< all dual cells of this block have it
    };
    /// Of the dual cell that begins at that voxel's centre.
    Clearance at(int32_t x, int32_t y, int32_t z) const {
        const uint32_t entry = entry_of({x >> 3, y >> 3, z >> 3});
        if ((entry & kUniform) != 0) return {static_cast<int32_t>(entry & ~kUniform), true};
        const auto place = static_cast<uint32_t>(((z & 7) << 6) | ((y & 7) << 3) | (x & 7));
        return {pool_[entry * kBlockBytes + place / 2] >> (place % 2 * 4) & 15, false};
    }
    Kind kind(const Vec3i& block) const;
    /// By block, x fastest: kUniform and what all its dual cells have, or which kBlockBytes of the pool have them, x fastest,
    /// low half bytes first.
    const uint32_t* entries() const { return entries_.data(); }
    const uint8_t* pool() const { return pool_.data(); }

  private:
    uint32_t entry_of(const Vec3i& block) const { return entries_[index_in(blocks_, block)]; }

    Vec3i blocks_;
    std::vector<uint32_t> entries_;
    std::vector<uint8_t> pool_;
};

}  // namespace openfab::render
