// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Thresholds of the ordered dither: a void-and-cluster mask in the plane, which from slice to slice
// keeps its pixels and turns its ranks.

#include <cstdint>

#include "runtime/abi/voxel_hash.h"

namespace openfab::slab {

constexpr int32_t kBlueNoiseSide = 64;

/// void_and_cluster(kBlueNoiseSide), written when the project is built.
extern const uint16_t kBlueNoiseRanks[kBlueNoiseSide * kBlueNoiseSide];

/// Turn of the ranks from a slice to the next, in 1/65536: (sqrt(13) - 3) / 2, which is far from
/// all fractions of small numbers, so a column of voxels sees evenly spread thresholds, too. Of an
/// even mixture of two, 61 % of the voxels differ from the one above. (The golden section would
/// make it 76 %.)
constexpr uint32_t kBlueNoiseTurn = 19843;

/// Rank of the pixel at (x, y) for a seed (fold_seed of voxel_hash.h), in steps of 1/65536.
inline uint32_t blue_noise_rank(int32_t x, int32_t y, uint32_t seed) {
    constexpr uint32_t kMask = kBlueNoiseSide - 1;
    const uint32_t shift = abi::mix32(seed);
    const uint32_t column = (static_cast<uint32_t>(x) + shift) & kMask;
    const uint32_t row = (static_cast<uint32_t>(y) + (shift >> 6)) & kMask;
    return kBlueNoiseRanks[row * kBlueNoiseSide + column] * 16u + 8u + (shift >> 16);
}

/// In [0, 65535), to be compared with sums of 16-bit fractions as voxel_hash.h's thresholds are.
inline int32_t blue_noise_threshold(uint32_t rank, int32_t z) {
    const uint32_t turned = rank + static_cast<uint32_t>(z) * kBlueNoiseTurn;
    return static_cast<int32_t>(abi::fraction_threshold(turned << 16));
}

}  // namespace openfab::slab
