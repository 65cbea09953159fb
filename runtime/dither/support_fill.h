// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Support in the slab loop: rows of blocks that have got their last code give their void voxels
// below the depth map to the support material, before they are packed.

#include <cstdint>

#include "runtime/dither/band.h"
#include "runtime/support_material/depth_map.h"

namespace openfab::slab {

struct SupportFill {
    const support::DepthMap* map = nullptr;  ///< null: no support
    uint8_t code = 0;

    bool on() const { return map != nullptr; }
};

/// Block columns [x, y) of a row of blocks that may have support at slice z or above; empty (x >=
/// y) where there is none.
Vec2<int32_t> support_blocks(const SupportFill& support, int32_t row, int32_t z);

/// Slices z to z + 7 of a band. Rows of the grid end at `height` voxels.
void add_support(const SupportFill& support, int32_t z, int32_t height, RowBand* band);

}  // namespace openfab::slab
