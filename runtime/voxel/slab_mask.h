// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What coverage says of a slab of 8 slices.

#include <cstdint>
#include <vector>

namespace openfab::voxel {

/// Coverage of 8 slices z0..z0+7 (z0 a multiple of 8) over a rectangle of columns aligned to 8.
/// mask[(y - y0) * stride + (x - x0)]: bit k is set where voxel (x, y, z0 + k) is inside.
struct SlabMask {
    int32_t x0 = 0, y0 = 0;         ///< multiples of 8
    int32_t width = 0, height = 0;  ///< multiples of 8; 0 if the part misses the slab
    std::vector<uint8_t> mask;      ///< stride == width
};

}  // namespace openfab::voxel
