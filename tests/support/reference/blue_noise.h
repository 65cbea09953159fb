// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The ordered dither's threshold at a single voxel; runtime/dither/dither_kernel.h computes whole
// rows.

#include "runtime/dither/blue_noise.h"

namespace openfab::reference {

/// Returns a threshold in [0, 65535), compared with sums of 16-bit fractions like those of
/// voxel_hash.h.
inline int32_t blue_noise_threshold(const Vec3i& voxel, dither::BlueNoiseFace face, uint32_t seed) {
    using enum dither::BlueNoiseFace;
    const dither::BlueNoiseOffset offset(seed, face);
    const int32_t along = face == kLowX || face == kHighX ? voxel.y : voxel.x;
    const uint16_t* ranks = face == kInside
                                ? dither::kBlueNoiseInside[offset.inside(voxel.x, voxel.y, voxel.z)]
                                : dither::kBlueNoiseSides[offset.upright(along, voxel.z)];
    const uint32_t rank =
        ranks[0] + offset.turn + dither::blue_noise_drift(voxel.x, voxel.y, voxel.z);
    return static_cast<int32_t>(abi::blue_noise_threshold(rank));
}

}  // namespace openfab::reference
