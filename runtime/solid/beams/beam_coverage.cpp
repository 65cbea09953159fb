// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/beams/beam_coverage.h"

#include <algorithm>
#include <bit>

#include "runtime/solid/coverage_strips.h"

namespace openfab::solid {

void BeamCoverage::cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop,
                         Tools* tools, voxel::SlabMask* out) const {
    for (int32_t y = columns.y0; y < columns.y1; y += kLargest) {
        for (int32_t x = columns.x0; x < columns.x1; x += kLargest) {
            if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
            const Vec3i lowest = Vec3i{x, y, kSlabSlices * slab} - base_;
            Box3f box =
                frame_.box(lowest, lowest + Vec3i{kLargest - 1, kLargest - 1, kSlabSlices - 1});
            const float margin = tree_.slack(box.hi);
            box.lo = box.lo - Vec3f{margin, margin, margin};
            box.hi = box.hi + Vec3f{margin, margin, margin};
            tools->found.clear();
            tree_.collect(box, &tools->found);
            if (!tools->found.empty())
                cover_tile(slab, x, y, kLargest, tools->found, columns, tools, out);
        }
    }
}

void BeamCoverage::cover_tile(int32_t slab, int32_t x, int32_t y, int32_t side,
                              std::span<const int32_t> beams, const Columns& columns, Tools* tools,
                              voxel::SlabMask* out) const {
    const VoxelBall ball =
        voxel_ball(frame_, Vec3i{x, y, kSlabSlices * slab} - base_, {side, side, kSlabSlices});
    BeamList& list =
        tools->lists[static_cast<size_t>(std::countr_zero(static_cast<uint32_t>(kLargest / side)))];
    if (list.gather_holding(tree_, ball, beams))
        return fill(x, y, side, slices_in(box_, slab), out);
    if (list.beams().empty()) return;
    if (side == 8) return cover_block(slab, x, y, list.beams(), tools, out);
    const int32_t half = side / 2;
    for (int32_t k = 0; k < 4; ++k) {
        const int32_t px = x + (k & 1) * half, py = y + (k >> 1) * half;
        if (px < columns.x1 && py < columns.y1)
            cover_tile(slab, px, py, half, list.beams(), columns, tools, out);
    }
}

void BeamCoverage::cover_block(int32_t slab, int32_t x, int32_t y, std::span<const int32_t> beams,
                               Tools* tools, voxel::SlabMask* out) const {
    for (int32_t k = 0; k < 8; ++k) {
        const Vec3i from{x + 4 * (k & 1), y + 4 * (k >> 1 & 1), kSlabSlices * slab + 4 * (k >> 2)};
        const uint32_t bits = slices_in(box_, slab) & (k < 4 ? 0x0fu : 0xf0u);
        if (bits == 0) continue;
        const VoxelBall ball = voxel_ball(frame_, from - base_, {4, 4, 4});
        if (tools->of_cube.gather_holding(tree_, ball, beams)) {
            fill(from.x, from.y, 4, static_cast<uint8_t>(bits), out);
            continue;
        }
        if (tools->of_cube.beams().empty()) continue;
        tools->cube.set(frame_, from - base_);
        tools->cube.find_distance(tree_.beams(), tools->of_cube.beams());
        for (int32_t column = 0; column < 16; ++column) {
            uint32_t in = 0;
            for (int32_t z = 0; z < 4; ++z)
                in |= (tools->cube.distance[4 * column + z] < 0 ? 1u : 0u) << (z + 4 * (k >> 2));
            if ((in & bits) != 0)
                fill(from.x + column % 4, from.y + column / 4, 1, static_cast<uint8_t>(in & bits),
                     out);
        }
    }
}

void BeamCoverage::fill(int32_t x, int32_t y, int32_t side, uint8_t bits,
                        voxel::SlabMask* out) const {
    const int32_t x0 = std::max(x, box_.lo.x);
    const int32_t x1 = std::min({x + side, box_.hi.x, out->x0 + out->width});
    const int32_t y0 = std::max(y, box_.lo.y);
    const int32_t y1 = std::min({y + side, box_.hi.y, out->y0 + out->height});
    for (int32_t row = y0; row < y1; ++row) {
        uint8_t* to =
            &out->mask[static_cast<size_t>(row - out->y0) * static_cast<size_t>(out->width)];
        for (int32_t column = x0; column < x1; ++column)
            to[column - out->x0] |= bits;
    }
}

}  // namespace openfab::solid
