// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The coverage of a slab that is decided tile by tile: a mask over the columns of a box, in strips of tiles side by side.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/stage_timer.h"
#include "base/vec.h"
#include "runtime/solid/tops.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::solid {

constexpr int32_t kSlabSlices = 8;

/// Returns the bits of a slab's slices that lie in the box.
inline uint8_t slices_in(const Box3i& box, int32_t slab) {
    uint32_t bits = 0;
    for (int32_t z = 0; z < kSlabSlices; ++z) {
        const int32_t at = kSlabSlices * slab + z;
        bits |= at >= box.lo.z && at < box.hi.z ? 1u << z : 0u;
    }
    return static_cast<uint8_t>(bits);
}

/// Clears the mask of a slab, of the box's columns, and calls `cover(columns)` for its strips of
/// `side` rows, in parallel. Adds the time that they take to `seconds`, which may be null.
template <typename Cover>
void cover_strips(const Box3i& box, int32_t slab, int32_t side, voxel::SlabMask* out,
                  double* seconds, const Cover& cover) {
    out->x0 = out->y0 = out->width = out->height = 0;
    out->mask.clear();
    if (slices_in(box, slab) == 0 || box.lo.x >= box.hi.x || box.lo.y >= box.hi.y) return;
    out->x0 = box.lo.x & ~7, out->y0 = box.lo.y & ~7;
    out->width = ((box.hi.x + 7) & ~7) - out->x0;
    out->height = ((box.hi.y + 7) & ~7) - out->y0;
    out->mask.assign(static_cast<size_t>(out->width) * static_cast<size_t>(out->height), 0);
    const int32_t strips = (out->height + side - 1) / side;
    std::atomic<double> taken{0};
    tbb::parallel_for(0, strips, [&](int32_t strip) {
        double mine = 0;
        {
            const StageTimer timer(Stage::kCoverage, &mine);
            const int32_t y0 = out->y0 + side * strip;
            cover(Columns{out->x0, y0, out->x0 + out->width,
                          std::min(y0 + side, out->y0 + out->height)});
        }
        taken += mine;
    });
    if (seconds != nullptr) *seconds += taken;
}

}  // namespace openfab::solid
