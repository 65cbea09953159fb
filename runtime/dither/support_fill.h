// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Support in the slab loop: after the dither, void voxels of a row of blocks that lie below the
// depth map become support material, before the row is packed.

#include <cstdint>

#include "runtime/dither/band.h"
#include "runtime/support_material/depth_map.h"

namespace openfab::dither {

struct SupportFill {
    const support_material::DepthMap* map = nullptr;  ///< null: no support
    uint8_t code = 0;

    bool on() const { return map != nullptr; }
};

/// Returns the block columns [x, y) of a row of blocks that may have support at slice z or above;
/// empty (x >= y) where there is none.
Vec2<int32_t> support_blocks(const SupportFill& support, int32_t row, int32_t z);

/// Adds support to slices z to z + 7 of a band. Rows of the grid end at `height` voxels.
void add_support(const SupportFill& support, int32_t z, int32_t height, RowBand* band);

}  // namespace openfab::dither
