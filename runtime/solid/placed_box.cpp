// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/placed_box.h"

#include <algorithm>
#include <cmath>

#include "runtime/surface/transform_box.h"

namespace openfab::solid {

Box3i voxels_of(const Place& where, const Box3f& box) {
    const Box3d inside = surface::transform_box(part::local_to_voxel(where.part, where.grid), box);
    Box3i out;
    for (int a = 0; a < 3; ++a) {
        const auto clamped = [&](double x) {
            return static_cast<int32_t>(
                std::clamp(x, 0.0, static_cast<double>(where.grid.size[a])));
        };
        out.lo[a] = clamped(std::floor(inside.lo[a]) - 1);
        out.hi[a] = clamped(std::ceil(inside.hi[a]) + 1);
    }
    if (out.lo.x >= out.hi.x || out.lo.y >= out.hi.y || out.lo.z >= out.hi.z)
        return {{0, 0, 0}, {0, 0, 0}};
    return out;
}

}  // namespace openfab::solid
