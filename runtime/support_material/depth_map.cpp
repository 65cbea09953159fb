// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/support_material/depth_map.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstring>

#include "base/check.h"
#include "base/units.h"
#include "runtime/support_material/messages.h"

namespace openfab::support_material {

namespace {

int32_t width_of(int32_t range) {
    return range == 0 ? 0 : range < 1 << 8 ? 1 : range < 1 << 16 ? 2 : 4;
}

void store(uint32_t value, int32_t width, uint8_t* to) {
    for (int32_t b = 0; b < width; ++b)
        to[b] = static_cast<uint8_t>(value >> (8 * b));
}

int32_t load(const uint8_t* from, int32_t width) {
    uint32_t value = 0;
    for (int32_t b = 0; b < width; ++b)
        value |= static_cast<uint32_t>(from[b]) << (8 * b);
    return static_cast<int32_t>(value);
}

/// The tops of one row of tiles.
void raise_rows(const std::vector<SupportedPart>& parts, const part::Grid& grid,
                solid::TopRows* rows) {
    const int32_t y1 = std::min(rows->y0 + DepthMap::kTile, grid.size.y);
    for (const SupportedPart& part : parts) {
        const solid::Columns columns{part.box.lo.x, std::max(part.box.lo.y, rows->y0),
                                     part.box.hi.x, std::min(part.box.hi.y, y1)};
        if (columns.empty()) continue;
        if (part.tops.empty()) {
            part.placed->raise_tops(columns, rows);
            continue;
        }
        for (int32_t y = columns.y0; y < columns.y1; ++y) {
            const int32_t* row = &part.tops[static_cast<size_t>(y - part.box.lo.y) *
                                            static_cast<size_t>(part.box.size().x)];
            for (int32_t x = columns.x0; x < columns.x1; ++x)
                rows->raise(x, y, row[x - part.box.lo.x]);
        }
    }
}

}  // namespace

DepthMap::DepthMap(const Vec3i& size) : size_(size) {
    tiles_x_ = (size.x + kTile - 1) / kTile;
    tiles_y_ = (size.y + kTile - 1) / kTile;
    tiles_.resize(static_cast<size_t>(tiles_x_) * static_cast<size_t>(tiles_y_));
    highest_.resize(static_cast<size_t>(tiles_y_));
    heights_.resize(static_cast<size_t>(tiles_y_));
}

Result<DepthMap> DepthMap::create(const std::vector<SupportedPart>& parts, const part::Grid& grid,
                                  int64_t max_bytes) {
    DepthMap map(grid.size);
    std::atomic<int64_t> bytes{map.bytes()};
    tbb::parallel_for(0, map.tiles_y_, [&](int32_t tile_y) {
        if (bytes > max_bytes) return;
        solid::TopRows rows;
        rows.width = map.tiles_x_ * kTile;
        rows.y0 = tile_y * kTile;
        rows.top.assign(static_cast<size_t>(rows.width) * kTile, 0);
        raise_rows(parts, grid, &rows);
        map.keep(tile_y, rows.top);
        bytes += static_cast<int64_t>(map.heights_[tile_y].capacity());
    });
    if (bytes > max_bytes) {
        // The final size is unknown; two bytes per column mostly suffice.
        const int64_t columns = int64_t{grid.size.x} * grid.size.y;
        return user_error(fmt::format(messages::kSupportTakesMemory,
                                      format_bytes(std::max<int64_t>(max_bytes, 0)),
                                      format_bytes(columns * (grid.size.z < 1 << 16 ? 2 : 4))));
    }
    return map;
}

/// `tops`: [y][x] of the row's tiles.
void DepthMap::keep(int32_t tile_y, const std::vector<int32_t>& tops) {
    const size_t stride = static_cast<size_t>(tiles_x_) * kTile;
    OPENFAB_CHECK_EQ(tops.size(), stride * kTile);
    std::vector<uint8_t>& heights = heights_[tile_y];
    size_t bytes = 0;
    for (const bool measure : {true, false}) {
        if (!measure) heights.resize(bytes);
        bytes = 0;
        for (int32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
            Tile& tile = tiles_[tile_number(tile_x, tile_y)];
            const int32_t* corner = tops.data() + static_cast<size_t>(tile_x) * kTile;
            if (measure) {
                tile.lo = tile.hi = corner[0];
                for (size_t y = 0; y < kTile; ++y) {
                    const auto [lo, hi] =
                        std::minmax_element(corner + y * stride, corner + y * stride + kTile);
                    tile.lo = std::min(tile.lo, *lo), tile.hi = std::max(tile.hi, *hi);
                }
                tile.width = width_of(tile.hi - tile.lo);
                tile.first = static_cast<uint32_t>(bytes);
                int32_t& highest = highest_[tile_y];
                highest = std::max(highest, tile.hi);
            }
            bytes += static_cast<size_t>(tile.width) * kTile * kTile;
            if (measure || tile.width == 0) continue;
            uint8_t* to = heights.data() + tile.first;
            for (size_t y = 0; y < kTile; ++y) {
                for (size_t x = 0; x < kTile; ++x, to += tile.width)
                    store(static_cast<uint32_t>(corner[y * stride + x] - tile.lo), tile.width, to);
            }
        }
    }
}

int32_t DepthMap::top(int32_t x, int32_t y) const {
    int32_t out;
    tops(x, y, 1, &out);
    return out;
}

void DepthMap::tops(int32_t x, int32_t y, int32_t count, int32_t* out) const {
    const int32_t tile_y = y / kTile;
    const std::vector<uint8_t>& heights = heights_[tile_y];
    for (const int32_t end = x + count; x < end;) {
        const Tile& tile = tiles_[tile_number(x / kTile, tile_y)];
        const int32_t stop = std::min(end, (x / kTile + 1) * kTile);
        const uint8_t* from = heights.data() + tile.first +
                              static_cast<ptrdiff_t>((y % kTile * kTile + x % kTile) * tile.width);
        for (; x < stop; ++x, from += tile.width)
            *out++ = tile.lo + load(from, tile.width);
    }
}

int64_t DepthMap::bytes() const {
    int64_t sum = static_cast<int64_t>(tiles_.size() * sizeof(Tile)) +
                  static_cast<int64_t>(highest_.size() * sizeof(int32_t));
    for (const auto& row : heights_)
        sum += static_cast<int64_t>(sizeof row + row.capacity());
    return sum;
}

}  // namespace openfab::support_material
