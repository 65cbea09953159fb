// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Coverage of a whole print, slab by slab.

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/part/part.h"
#include "runtime/solid/solid.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

/// The covered voxels, [z][y][x].
inline std::vector<uint8_t> covered(const Placed& placed, const part::Grid& grid) {
    std::vector<uint8_t> all(static_cast<size_t>(grid.size.x) * grid.size.y * grid.size.z, 0);
    voxel::SlabMask mask;
    for (int32_t slab = 0; 8 * slab < grid.size.z; ++slab) {
        placed.coverage(slab, &mask, nullptr, nullptr);
        for (int32_t y = 0; y < mask.height; ++y) {
            for (int32_t x = 0; x < mask.width; ++x) {
                const uint8_t bits = mask.mask[static_cast<size_t>(y) * mask.width + x];
                for (int32_t z = 0; z < 8; ++z) {
                    if ((bits >> z & 1) == 0) continue;
                    const Vec3i at{mask.x0 + x, mask.y0 + y, 8 * slab + z};
                    EXPECT_TRUE(at.x < grid.size.x && at.y < grid.size.y && at.z < grid.size.z);
                    all[(static_cast<size_t>(at.z) * grid.size.y + at.y) * grid.size.x + at.x] = 1;
                }
            }
        }
    }
    return all;
}

}  // namespace openfab::solid
