// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The height up to which each column of voxels needs support: the depth map of the OpenFab paper,
// section 5.1, seen from above along z.
//
// A part without displacement contributes the highest voxel that it covers in each column, exactly.
// Any other contributes its base triangles grown by their displacement bounds, rounded up, which is
// never too low. A column gets the highest of all parts.

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/solid/solid.h"

namespace openfab::support_material {

/// A part that needs support below it.
struct SupportedPart {
    const solid::Placed* placed = nullptr;
    Box3i box;  ///< voxels that it may cover, within the grid
    /// Of a piece: the top of each column of the box, row by row; else the solid is asked.
    std::vector<int32_t> tops = {};
};

/// The depth map, in compressed tiles.
class DepthMap {
  public:
    /// Columns along a tile's side. A tile keeps heights above its lowest in 1, 2 or 4 bytes per
    /// column, or none if all are equal.
    static constexpr int32_t kTile = 32;

    /// Computes the map, in parallel in TBB's current arena. An error if it would take more than
    /// `max_bytes`.
    static Result<DepthMap> create(const std::vector<SupportedPart>& parts, const part::Grid& grid,
                                   int64_t max_bytes);

    /// Returns the top of column (x, y): a void voxel is support if its z is below this.
    int32_t top(int32_t x, int32_t y) const;
    /// Gets the tops of columns [x, x + count) of row y.
    void tops(int32_t x, int32_t y, int32_t count, int32_t* out) const;

    /// The range of tops in a tile.
    struct Range {
        int32_t lo = 0, hi = 0;
    };
    /// Returns the range of the tile of column (32 tile_x, y).
    Range tile_range(int32_t tile_x, int32_t y) const {
        const Tile& tile = tiles_[tile_number(tile_x, y / kTile)];
        return {tile.lo, tile.hi};
    }
    int32_t tiles_x() const { return tiles_x_; }
    /// Returns the greatest top in the row of tiles that holds row y.
    int32_t highest(int32_t y) const { return highest_[static_cast<size_t>(y / kTile)]; }
    int64_t bytes() const;

  private:
    struct Tile {
        int32_t lo = 0, hi = 0;
        int32_t width = 0;   ///< bytes per column
        uint32_t first = 0;  ///< in the heights of its row of tiles
    };
    DepthMap(const Vec3i& size);
    size_t tile_number(int32_t tile_x, int32_t tile_y) const {
        return static_cast<size_t>(tile_y) * static_cast<size_t>(tiles_x_) +
               static_cast<size_t>(tile_x);
    }
    void keep(int32_t tile_y, const std::vector<int32_t>& tops);

    Vec3i size_;
    int32_t tiles_x_ = 0, tiles_y_ = 0;
    std::vector<Tile> tiles_;
    std::vector<int32_t> highest_;               ///< [tile row]
    std::vector<std::vector<uint8_t>> heights_;  ///< [tile row]: tiles, in them rows of 32 columns
};

}  // namespace openfab::support_material
