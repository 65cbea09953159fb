// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thresholds of the ordered dither: a void-and-cluster mask in the plane, which is shifted from
// slice to slice. A vertical layer one voxel thick, or one at 45 degrees, meets pixels all over the
// mask, so its mean is nearly the mask's, which is exact. (Rotating the ranks in place instead gave
// an error of 4 %, root mean square, for 2 % in such layers of 64 x 64 voxels.)
//
// The visible part of a print is its skin, and a skin that cuts through slices samples the mask at
// unrelated points: it would look like white noise, and the printed fraction in an octant of a ball
// would err by as much. So voxels at the border of a mixed region use a mask in the plane of their
// side, a second one, since each is made for what a rod of 8 x 8 voxels takes of it: every side,
// flat or curved, shows blue noise. Thresholds are uniform in (0, 1) at each voxel, so that the mean
// is right in every layer, edge and thin feature, whatever its neighbours.

#include <cstdint>

#include "abi/voxel_hash.h"
#include "base/vec.h"

namespace openfab::dither {

/// Pixel x - kBlueNoiseRow y, modulo the number of pixels, is at (x, y). So squares of that many rows
/// tile the plane, each one pixel off its neighbours: a line of voxels goes on in the next line of
/// the mask instead of repeating its own, which averages the errors of long thin features.
constexpr uint32_t kBlueNoiseRow = 64;
constexpr uint32_t kBlueNoisePixels = kBlueNoiseRow * kBlueNoiseRow + 1;
/// The pixels that the mask moves by from one slice to the next: copies of a pixel in nearby slices
/// are far apart, 21 pixels for up to 5 slices, and a column of 64 voxels meets all parts of it.
constexpr uint32_t kBlueNoiseSliceStep = 1273;

/// void_and_cluster(kBlueNoiseRow, …) in 1/65536, generated at build time: the ranks of a pixel and
/// of those that its place has in the next seven slices, which are a vector's lanes.
using BlueNoiseMask = uint16_t[kBlueNoisePixels][8];
extern const BlueNoiseMask kBlueNoiseInside, kBlueNoiseSides;

/// Returns an index modulo the number of pixels, also if it is negative.
inline uint32_t blue_noise_index(int32_t i) {
    const int32_t rest = i % static_cast<int32_t>(kBlueNoisePixels);
    return static_cast<uint32_t>(rest < 0 ? rest + static_cast<int32_t>(kBlueNoisePixels) : rest);
}

/// The direction that the border of a region faces at a voxel. Only neighbours in the slice count,
/// since slices are independent; tops and bottoms are planes of the mask anyway.
enum class BlueNoiseFace : uint32_t { kInside, kLowX, kHighX, kLowY, kHighY };

/// The rotation of ranks from voxel to voxel, a 16th of the step between two ranks: it prints
/// fractions below one level of the mask. Ten times as much would make the ends of a short rod use
/// other pixels than its middle: 1 % in 8 x 8 x 64 voxels would err by 8 instead of 5 % (root mean
/// square).
inline uint32_t blue_noise_drift(int32_t x, int32_t y, int32_t z) {
    return static_cast<uint32_t>(x) + static_cast<uint32_t>(y) + static_cast<uint32_t>(z);
}

/// The shift and rotation of the mask of one face by a seed (fold_seed of voxel_hash.h).
struct BlueNoiseOffset {
    uint32_t pixel, turn;

    BlueNoiseOffset(uint32_t seed, BlueNoiseFace face) {
        const uint32_t shift = abi::mix32(seed + static_cast<uint32_t>(face) * 0x9e3779b1u);
        pixel = (shift & 0xffff) % kBlueNoisePixels;
        turn = shift >> 16;
    }
    /// Returns a voxel's pixel in the mask inside a region.
    uint32_t inside(int32_t x, int32_t y, int32_t z) const {
        return (upright(x, y) + kBlueNoiseSliceStep * blue_noise_index(z)) % kBlueNoisePixels;
    }
    /// Returns a voxel's pixel in the vertical mask of a side, `along` which y runs where the side
    /// faces x, x where it faces y.
    uint32_t upright(int32_t along, int32_t z) const {
        return (pixel + blue_noise_index(along) +
                (kBlueNoisePixels - kBlueNoiseRow) * blue_noise_index(z)) %
               kBlueNoisePixels;
    }
};

/// Returns the pixel after one, along a row of voxels.
inline uint32_t next_blue_noise(uint32_t pixel) {
    return pixel + 1 < kBlueNoisePixels ? pixel + 1 : 0;
}

/// Bits of 8 slices: whether a voxel and its neighbours are mixed.
struct BlueNoiseNeighbours {
    uint32_t here, low_x, high_x, low_y, high_y;
    uint32_t low_low, high_low, low_high, high_high;  ///< in x and y
};

/// Bits of 8 slices, mutually exclusive. A side that faces x has one voxel in each row of voxels
/// and one that faces y has one in each column, so that no entry of a vertical mask is used twice.
struct BlueNoiseFaces {
    uint32_t low_x, high_x, low_y, high_y;

    explicit BlueNoiseFaces(const BlueNoiseNeighbours& mixed) {
        const uint32_t left = ~mixed.low_x, right = ~mixed.high_x;
        const uint32_t down = ~mixed.low_y, up = ~mixed.high_y;
        // Outer corners of a staircase face both directions and belong to the longer step.
        const uint32_t level = (left & ~right & down & ~up & mixed.low_high & ~mixed.high_low) |
                               (left & ~right & ~down & up & mixed.low_low & ~mixed.high_high) |
                               (~left & right & down & ~up & mixed.high_high & ~mixed.low_low) |
                               (~left & right & ~down & up & mixed.high_low & ~mixed.low_high);
        const uint32_t faces_x = mixed.here & (left | right) & ~level;
        low_x = faces_x & left;
        high_x = faces_x & ~left;
        const uint32_t faces_y = mixed.here & (down | up) & ~faces_x;
        low_y = faces_y & down;
        high_y = faces_y & ~down;
    }
};

}  // namespace openfab::dither
