// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thresholds of the ordered dither: a void-and-cluster mask in the plane, which is shifted from
// slice to slice. A layer one voxel thick, vertical or at 45 degrees, meets every line of the mask
// once in kBlueNoiseSide slices, so its mean is the mask's, which is exact. (Rotating the ranks in
// place instead gave an error of 4 %, root mean square, for 2 % in such layers of 64 x 64 voxels.)
//
// The visible part of a print is its skin, and a skin that cuts through slices samples the mask at
// unrelated points: it would look like white noise, and the printed fraction in an octant of a ball
// would err by as much. So voxels at the border of a mixed region use the mask in the plane of
// their side: every side, flat or curved, shows blue noise. Thresholds are uniform in (0, 1) at
// each voxel, so that the mean is right in every layer, edge and thin feature, whatever its
// neighbours.

#include <cstdint>

#include "abi/voxel_hash.h"
#include "base/vec.h"

namespace openfab::dither {

/// A prime, so that the shifts from slice to slice, those plus and minus one, their sum and their
/// difference all cycle through all lines.
constexpr uint32_t kBlueNoiseSide = 61;
/// The shift of the mask from one slice to the next: the one that keeps copies of a pixel in nearby
/// slices farthest apart, 21 pixels for up to 5 slices.
constexpr uint32_t kBlueNoiseStepX = 20, kBlueNoiseStepY = 13;

/// void_and_cluster(kBlueNoiseSide, …) in 1/65536, generated at build time; each line is stored
/// twice, so that a shift along x needs no wrap.
constexpr uint32_t kBlueNoiseStride = 2 * kBlueNoiseSide;
extern const uint16_t kBlueNoiseMask[kBlueNoiseSide * kBlueNoiseStride];

/// Returns a voxel's index in the periodic mask: modulo kBlueNoiseSide, also of negative indices.
inline uint32_t blue_noise_index(int32_t i) {
    const int32_t rest = i % static_cast<int32_t>(kBlueNoiseSide);
    return static_cast<uint32_t>(rest < 0 ? rest + static_cast<int32_t>(kBlueNoiseSide) : rest);
}

/// The direction that the border of a region faces at a voxel. Only neighbours in the slice count,
/// since slices are independent; tops and bottoms are planes of the mask anyway.
enum class BlueNoiseFace : uint32_t { kInside, kLowX, kHighX, kLowY, kHighY };

/// The rotation of ranks from voxel to voxel: less than the step between two ranks, but a hundredth
/// of their range from one copy of the mask to the next. So copies differ, and their errors in thin
/// features average out: without it, rods of 8 x 8 voxels print 1 % with an error of 9 % (root mean
/// square), however long they are; with it 1.5 % over 8 copies. It also prints fractions below one
/// level of the mask. Twice as much would visibly affect how evenly 0.5 % is distributed.
constexpr uint32_t kBlueNoiseDriftX = 11, kBlueNoiseDriftY = 9, kBlueNoiseDriftZ = 13;

/// Returns the rotation that is added to a rank, modulo 2^16.
inline uint32_t blue_noise_drift(int32_t x, int32_t y, int32_t z) {
    return kBlueNoiseDriftX * static_cast<uint32_t>(x) +
           kBlueNoiseDriftY * static_cast<uint32_t>(y) +
           kBlueNoiseDriftZ * static_cast<uint32_t>(z);
}

/// The shift and rotation of the mask of one face by a seed (fold_seed of voxel_hash.h).
struct BlueNoiseOffset {
    uint32_t x, y, turn;

    BlueNoiseOffset(uint32_t seed, BlueNoiseFace face) {
        const uint32_t shift = abi::mix32(seed + static_cast<uint32_t>(face) * 0x9e3779b1u);
        x = (shift & 255) % kBlueNoiseSide;
        y = (shift >> 8 & 255) % kBlueNoiseSide;
        turn = shift >> 16;
    }
    /// Returns the mask inside a region at y in slice z, indexed by blue_noise_index(x).
    const uint16_t* line(int32_t at_y, int32_t z) const {
        const uint32_t slice = blue_noise_index(z);
        const uint32_t row =
            (blue_noise_index(at_y) + y + kBlueNoiseStepY * slice) % kBlueNoiseSide;
        return &kBlueNoiseMask[row * kBlueNoiseStride +
                               (x + kBlueNoiseStepX * slice) % kBlueNoiseSide];
    }
    /// Returns the vertical mask of a side in slice z, indexed by blue_noise_index(y) where the
    /// side faces x, by blue_noise_index(x) where it faces y.
    const uint16_t* upright(int32_t z) const {
        return &kBlueNoiseMask[(blue_noise_index(z) + y) % kBlueNoiseSide * kBlueNoiseStride + x];
    }
};

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
