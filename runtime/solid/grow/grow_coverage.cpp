// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/grow_coverage.h"

#include <algorithm>

#include "runtime/solid/coverage_strips.h"

namespace openfab::solid {

namespace {

/// Voxels along x of a tile that is gathered at once, in strips of BeamCoverage::kLargest rows.
constexpr int32_t kGathered = 128;

}  // namespace

void GrowCoverage::coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                            double* seconds) const {
    cover_strips(box_, slab, BeamCoverage::kLargest, out, seconds, [&](const Columns& columns) {
        Tools tools;
        cover(slab, columns, stop, &tools, out);
    });
}

void GrowCoverage::cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop,
                         Tools* tools, voxel::SlabMask* out) const {
    for (int32_t y = columns.y0; y < columns.y1; y += BeamCoverage::kLargest) {
        for (int32_t x = columns.x0; x < columns.x1; x += kGathered) {
            if (grown_.failed() || (stop != nullptr && stop->load(std::memory_order_relaxed)))
                return;
            const Columns tile{x, y, std::min(x + kGathered, columns.x1),
                               std::min(y + BeamCoverage::kLargest, columns.y1)};
            const Vec3i lowest = Vec3i{x, y, kSlabSlices * slab} - base_;
            Box3f box = frame_.box(
                lowest, lowest + Vec3i{kGathered - 1, BeamCoverage::kLargest - 1, kSlabSlices - 1});
            const float margin = grown_.slack(box.hi);
            box.lo = box.lo - Vec3f{margin, margin, margin};
            box.hi = box.hi + Vec3f{margin, margin, margin};
            tools->gathered.clear();
            grown_.collect(box, &tools->gathered);
            if (tools->gathered.beams.empty()) continue;
            tools->local.set(tools->gathered, grown_.center(), nullptr);
            BeamCoverage(tools->local.tree(), frame_, box_, base_)
                .cover(slab, tile, stop, &tools->of_beams, out);
        }
    }
}

void GrowCoverage::raise_tops(const Columns& columns, TopRows* rows) const {
    Tools tools;
    raise_to_covered(box_, columns, rows,
                     [&](int32_t slab, const Columns& all, voxel::SlabMask* mask) {
                         cover(slab, all, nullptr, &tools, mask);
                     });
}

}  // namespace openfab::solid
