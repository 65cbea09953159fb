// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/crowding.h"

#include <algorithm>

namespace openfab::surface {

namespace {

double volume(const Box3f& box) {
    const Vec3d size = vec_cast<double>(box.size());
    return size.x * size.y * size.z;
}

/// Returns the triangles of a tile of the lattice of factor n.
int64_t triangles_of(const std::array<int32_t, 4>& tile, int32_t n) {
    int64_t triangles = 0;
    for (int32_t b = tile[1]; b < tile[3]; ++b) {
        const int64_t cells = std::min(tile[2], n - b) - tile[0];
        // The last cell of a row at the far side is half a cell.
        triangles += 2 * cells - (tile[2] >= n - b ? 1 : 0);
    }
    return triangles;
}

}  // namespace

double crowding(const std::vector<Patch>& patches) {
    Box3f whole;
    double sum = 0;
    int32_t n = 0;  // factor of the lattice: its first row of tiles reaches the far corner
    for (size_t p = 0; p < patches.size(); ++p) {
        const Patch& patch = patches[p];
        if (patch.bounds.empty()) continue;
        whole.add(patch.bounds);
        if (patch.kind != PatchKind::kLattice) continue;
        if (p == 0 || patches[p - 1].triangle != patch.triangle) {
            n = 0;
            for (size_t q = p; q < patches.size() && patches[q].triangle == patch.triangle; ++q)
                n = std::max(n, patches[q].lattice[2]);
        }
        sum += static_cast<double>(triangles_of(patch.lattice, n)) * volume(patch.bounds);
    }
    const double all = volume(whole);
    return all > 0 ? sum / all : 0;
}

}  // namespace openfab::surface
