// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thresholds of the ordered dither: a void-and-cluster mask in the plane, which moves on from slice
// to slice. A layer one voxel thick, upright or at 45 degrees, meets every line of the mask once in
// kBlueNoiseSide slices, so its mean is the mask's, which is exact. (Turning the ranks in place
// instead printed 4 % more or less, root mean square, of 2 % in such layers of 64 x 64 voxels.)

#include <cstdint>

#include "runtime/abi/voxel_hash.h"
#include "runtime/base/vec.h"

namespace openfab::slab {

/// A prime, so that the steps from slice to slice, one more, one less, their sum and their
/// difference all run through all lines.
constexpr uint32_t kBlueNoiseSide = 61;
/// How far the mask moves from a slice to the next: of all steps those for which copies of a pixel
/// in slices near each other stay farthest apart, 21 pixels for up to 5 slices.
constexpr uint32_t kBlueNoiseStepX = 20, kBlueNoiseStepY = 13;

/// void_and_cluster(kBlueNoiseSide, …) in 1/65536, written when the project is built; each line
/// twice in a row, so that one shifted along x needs no wrap.
constexpr uint32_t kBlueNoiseStride = 2 * kBlueNoiseSide;
extern const uint16_t kBlueNoiseMask[kBlueNoiseSide * kBlueNoiseStride];

/// Where the mask, which goes on in all directions, has a voxel's index: modulo kBlueNoiseSide, of
/// negative ones too.
inline uint32_t blue_noise_index(int32_t i) {
    const int32_t rest = i % static_cast<int32_t>(kBlueNoiseSide);
    return static_cast<uint32_t>(rest < 0 ? rest + static_cast<int32_t>(kBlueNoiseSide) : rest);
}

/// Where a seed (fold_seed of voxel_hash.h) puts the mask, and what it adds to the ranks.
struct BlueNoisePlace {
    uint32_t x, y, turn;

    explicit BlueNoisePlace(uint32_t seed) {
        const uint32_t shift = abi::mix32(seed);
        x = (shift & 255) % kBlueNoiseSide;
        y = (shift >> 8 & 255) % kBlueNoiseSide;
        turn = shift >> 16;
    }
    /// The mask at y in slice z, from the value of x = 0 on: blue_noise_index(x) is its index.
    const uint16_t* line(int32_t at_y, int32_t z) const {
        const uint32_t slice = blue_noise_index(z);
        const uint32_t row =
            (blue_noise_index(at_y) + y + kBlueNoiseStepY * slice) % kBlueNoiseSide;
        return &kBlueNoiseMask[row * kBlueNoiseStride +
                               (x + kBlueNoiseStepX * slice) % kBlueNoiseSide];
    }
};

/// In [0, 65535), to be compared with sums of 16-bit fractions as voxel_hash.h's thresholds are.
inline int32_t blue_noise_threshold(const Vec3i& voxel, uint32_t seed) {
    const BlueNoisePlace place(seed);
    const uint32_t rank = place.line(voxel.y, voxel.z)[blue_noise_index(voxel.x)];
    return static_cast<int32_t>(abi::fraction_threshold((rank + place.turn) << 16));
}

}  // namespace openfab::slab
