// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/dither/support_fill.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace openfab::dither {

namespace {

using support_material::DepthMap;

constexpr uint64_t kOnes = 0x0101010101010101u;
constexpr int32_t kTileBlocks = DepthMap::kTile / 8;

/// Sets the bytes of `codes` that are 0 and among the `below` lowest to `code`.
uint64_t filled(uint64_t codes, int32_t below, uint64_t code_everywhere) {
    const uint64_t low7 = 0x7f * kOnes;
    const uint64_t used = (((codes & low7) + low7) | codes) >> 7 & kOnes;  // 1 where not 0
    const uint64_t reach = below >= 8 ? ~uint64_t{0} : (uint64_t{1} << (8 * below)) - 1;
    return codes | (code_everywhere & ((kOnes ^ used) * 255) & reach);
}

void fill_columns(uint8_t* codes, const int32_t* tops, int32_t count, int32_t z, uint64_t code) {
    for (int32_t x = 0; x < count; ++x, codes += 8) {
        const int32_t below = tops[x] - z;
        if (below <= 0) continue;
        uint64_t column;
        std::memcpy(&column, codes, 8);
        column = filled(column, below, code);
        std::memcpy(codes, &column, 8);
    }
}

}  // namespace

Vec2<int32_t> support_blocks(const SupportFill& support, int32_t row, int32_t z) {
    const DepthMap& map = *support.map;
    Vec2<int32_t> blocks{0, 0};
    if (map.highest(8 * row) <= z) return blocks;
    int32_t first = 0, end = map.tiles_x();
    while (first < end && map.tile_range(first, 8 * row).hi <= z)
        ++first;
    while (first < end && map.tile_range(end - 1, 8 * row).hi <= z)
        --end;
    return {first * kTileBlocks, end * kTileBlocks};
}

void add_support(const SupportFill& support, int32_t z, int32_t height, RowBand* band) {
    const DepthMap& map = *support.map;
    const uint64_t code = support.code * kOnes;
    const int32_t rows = std::min(8, height - 8 * band->row);
    const int32_t end = 8 * band->end_block;
    for (int32_t x = 8 * band->first_block; x < end;) {
        const int32_t tile = x / DepthMap::kTile;
        const int32_t stop = std::min(end, (tile + 1) * DepthMap::kTile);
        const DepthMap::Range range = map.tile_range(tile, 8 * band->row);
        std::array<int32_t, DepthMap::kTile> tops;
        tops.fill(range.lo);
        for (int32_t y = 0; y < rows && range.hi > z; ++y) {
            // If all columns reach above the slab, no comparison is needed.
            if (range.lo != range.hi && range.lo < z + 8)
                map.tops(x, 8 * band->row + y, stop - x, tops.data());
            fill_columns(band->codes_at(x, y), tops.data(), stop - x, z, code);
        }
        x = stop;
    }
}

}  // namespace openfab::dither
