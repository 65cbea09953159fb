// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"

namespace openfab::nearest {

/// Numbers distinct positions in order of first occurrence. -0 and 0 are equal.
class VertexNumbers {
  public:
    /// Makes room for at most `most` calls of `add`.
    explicit VertexNumbers(size_t most) : slots_(std::bit_ceil(2 * most + 1), kNone) {}

    /// Returns the number of a position, a new one if it was not added before.
    uint32_t add(const Vec3f& position) {
        const Vec3f p = position + Vec3f{0, 0, 0};
        uint32_t& slot = slots_[slot_of(p)];
        if (slot == kNone) {
            slot = static_cast<uint32_t>(positions_.size());
            positions_.push_back(p);
        }
        return slot;
    }
    /// Returns whether a position was added.
    bool has(const Vec3f& position) const {
        return slots_[slot_of(position + Vec3f{0, 0, 0})] != kNone;
    }
    /// The positions by number.
    const std::vector<Vec3f>& positions() const { return positions_; }

  private:
    /// Returns the slot where p is or would be.
    size_t slot_of(const Vec3f& p) const {
        const size_t mask = slots_.size() - 1;
        const uint64_t x = std::bit_cast<uint32_t>(p.x), y = std::bit_cast<uint32_t>(p.y),
                       z = std::bit_cast<uint32_t>(p.z);
        uint64_t hash =
            (x * 0x9e3779b97f4a7c15u) ^ (y * 0xc2b2ae3d27d4eb4fu) ^ (z * 0x165667b19e3779f9u);
        hash ^= hash >> 29;
        size_t slot = hash * 0x9e3779b97f4a7c15u >> 20 & mask;
        while (slots_[slot] != kNone && !(positions_[slots_[slot]] == p))
            slot = (slot + 1) & mask;
        return slot;
    }

    static constexpr uint32_t kNone = UINT32_MAX;
    std::vector<uint32_t> slots_;
    std::vector<Vec3f> positions_;
};

}  // namespace openfab::nearest
