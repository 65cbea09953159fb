// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers the corners of a mesh by their positions. Triangles come in the order of a mesher, so those two half voxels below
// the highest corner are never seen again, and are forgotten.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <unordered_map>

#include "backends/boundary/mesher.h"
#include "base/hash.h"

namespace openfab::boundary {

class PositionIndex {
  public:
    /// Memory for each voxel of a slice, in bytes, of a dithered mixture: about eight corners in three planes.
    static constexpr int64_t kBytesPerColumn = 8 * 64;

    /// Returns the number of the corner's position, from 0, and whether it is new.
    std::pair<uint32_t, bool> number(const MeshCorner& corner) {
        const auto [at, added] = planes_[corner.point.z].try_emplace(
            Key{corner.point.x, corner.point.y, corner.off[0], corner.off[1], corner.off[2]},
            count_);
        count_ += added ? 1 : 0;
        planes_.erase(planes_.begin(), planes_.lower_bound(planes_.rbegin()->first - 2));
        return {at->second, added};
    }

  private:
    using Key = std::array<int32_t, 5>;
    struct HashKey {
        size_t operator()(const Key& key) const {
            Hasher hash;
            for (const int32_t number : key)
                hash.add(number);
            return static_cast<size_t>(hash.value());
        }
    };
    std::map<int32_t, std::unordered_map<Key, uint32_t, HashKey>>
        planes_;  ///< by z, in half voxels
    uint32_t count_ = 0;
};

}  // namespace openfab::boundary
