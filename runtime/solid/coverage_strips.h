// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The coverage of a slab that is decided tile by tile: a mask over the columns of a box, in strips of tiles side by side.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <vector>

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

/// Raises tops to the highest voxel that is covered in each column. `cover(slab, columns, mask)` sets the
/// bits of a slab in a mask that is clear.
template <typename Cover>
void raise_to_covered(const Box3i& box, const Columns& columns, TopRows* rows, const Cover& cover) {
    if (columns.empty()) return;
    voxel::SlabMask mask;
    mask.x0 = columns.x0 & ~7, mask.y0 = columns.y0 & ~7;
    mask.width = ((columns.x1 + 7) & ~7) - mask.x0;
    mask.height = ((columns.y1 + 7) & ~7) - mask.y0;
    const auto size = static_cast<size_t>(mask.width) * static_cast<size_t>(mask.height);
    std::vector<uint8_t> done(size, 0);
    size_t left = columns.count();
    for (int32_t slab = (box.hi.z - 1) / kSlabSlices; slab >= box.lo.z / kSlabSlices && left > 0;
         --slab) {
        mask.mask.assign(size, 0);
        cover(slab, Columns{mask.x0, mask.y0, mask.x0 + mask.width, mask.y0 + mask.height}, &mask);
        for (int32_t y = columns.y0; y < columns.y1; ++y) {
            for (int32_t x = columns.x0; x < columns.x1; ++x) {
                const size_t i =
                    static_cast<size_t>(y - mask.y0) * static_cast<size_t>(mask.width) +
                    static_cast<size_t>(x - mask.x0);
                if (mask.mask[i] == 0 || done[i] != 0) continue;
                done[i] = 1;
                --left;
                rows->raise(x, y, kSlabSlices * slab + std::bit_width(mask.mask[i]) - 1);
            }
        }
    }
}

}  // namespace openfab::solid
