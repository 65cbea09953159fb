// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Centers of single voxels.

#include <array>

#include "abi/fablet_table.h"
#include "base/vec.h"

namespace openfab::nearest {

/// Returns the center of the voxel with this part-relative index, part-local mm, in the order of
/// operations that abi/fablet_table.h gives. `frame` is from part::make_frame.
inline Vec3f voxel_center(const std::array<float, OPENFAB_FRAME_COUNT>& frame, const Vec3i& voxel) {
    const float x = static_cast<float>(voxel.x) + 0.5f;
    const float y = static_cast<float>(voxel.y) + 0.5f;
    const float z = static_cast<float>(voxel.z) + 0.5f;
    Vec3f p;
    for (int c = 0; c < 3; ++c) {
        const auto at = [&](int base) { return frame[static_cast<size_t>(base + c)]; };
        p[c] = ((x * at(OPENFAB_FRAME_STEP_I) + y * at(OPENFAB_FRAME_STEP_J)) +
                z * at(OPENFAB_FRAME_STEP_K)) +
               at(OPENFAB_FRAME_ORIGIN);
    }
    return p;
}

}  // namespace openfab::nearest
