// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Draws a part of a plane of voxels as a PNG, at the resolution that is asked for. Where a pixel
// stands for many voxels, it is the mean of their colours in linear light, as dithered materials
// look from afar; where it stands for one, it is that one's colour, in an indexed picture.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace openfab::viewer {

constexpr int32_t kTilePixels = 512;
/// Highest level: voxels a pixel are 2^level along an axis.
constexpr int32_t kMostLevel = 12;

/// RGBA by code; code 0 is void.
using Palette = std::array<std::array<uint8_t, 4>, 256>;

/// Rows of packed codes, of which row 0 is the lowest.
struct Plane {
    int32_t width = 0, height = 0;
    int32_t bits = 4;
    /// Returns row v, valid until the next call; null where it is not there.
    std::function<const uint8_t*(int32_t v)> row;
    /// Whether a pixel takes one row instead of the mean of all of its rows: of planes whose rows
    /// are dear.
    bool sampled = false;
};

/// Tile (u, v) covers the voxels from u * kTilePixels * 2^level_u on, likewise along v. A sampled
/// plane may be `coarse`: a pixel then stands for so many times the rows.
struct TilePlace {
    int32_t level_u = 0, level_v = 0;
    int32_t u = 0, v = 0;
    int32_t coarse = 1;

    int64_t first_u() const { return (int64_t{u} * kTilePixels) << level_u; }
    int64_t first_v() const { return (int64_t{v} * kTilePixels) << level_v; }
    /// Rows a pixel.
    int64_t rows_a_pixel() const { return int64_t{coarse} << level_v; }
    /// One past the last row, of a plane of so many.
    int64_t end_v(int32_t height) const {
        const int64_t end = first_v() + (int64_t{kTilePixels} << level_v);
        return end < height ? end : height;
    }
};

/// Returns a PNG file, highest row first; empty where the tile lies beside the plane, or memory ran
/// out.
std::vector<uint8_t> draw_tile(const Plane& plane, const TilePlace& place, const Palette& palette);

/// Encodes linear light, 0 … 1, as an sRGB byte.
uint8_t srgb_of(double linear);

}  // namespace openfab::viewer
