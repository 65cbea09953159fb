// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/grow_coverage.h"

#include <algorithm>
#include <bit>

#include "runtime/solid/coverage_strips.h"
#include "runtime/solid/grow/thin_beams.h"

namespace openfab::solid {

namespace {

/// Voxels along x of a tile that is gathered at once, in strips of kLargest rows.
constexpr int32_t kGathered = 128;
/// Beams of a tile that is not halved: its tree stays in the caches of the processor, and threads need little memory.
constexpr size_t kFew = size_t{1} << 14;

}  // namespace

void GrowCoverage::cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop,
                         Tools* tools, voxel::SlabMask* out) const {
    for (int32_t y = columns.y0; y < columns.y1; y += kLargest) {
        for (int32_t x = columns.x0; x < columns.x1; x += kGathered) {
            if (grown_.failed() || (stop != nullptr && stop->load(std::memory_order_relaxed)))
                return;
            cover_tile(
                slab,
                {x, y, std::min(x + kGathered, columns.x1), std::min(y + kLargest, columns.y1)},
                stop, tools, out);
        }
    }
}

/// Halves a tile where beams crowd.
void GrowCoverage::cover_tile(int32_t slab, const Columns& tile, const std::atomic<bool>* stop,
                              Tools* tools, voxel::SlabMask* out) const {
    const int32_t width = tile.x1 - tile.x0, height = tile.y1 - tile.y0;
    const uint8_t bits = slices_in(box_, slab);
    if (bits == 0) return;
    const Vec3i lowest =
        Vec3i{tile.x0, tile.y0, kSlabSlices * slab + std::countr_zero(bits)} - base_;
    const int32_t slices = std::bit_width(bits) - std::countr_zero(bits);
    Box3f box = frame_.box(lowest, lowest + Vec3i{width - 1, height - 1, slices - 1});
    const float margin = grown_.slack(box.hi, 0);
    box.lo = box.lo - Vec3f{margin, margin, margin};
    box.hi = box.hi + Vec3f{margin, margin, margin};
    tools->gathered.clear();
    const Columns inside{std::max(tile.x0, box_.lo.x), std::max(tile.y0, box_.lo.y),
                         std::min({tile.x1, box_.hi.x, out->x0 + out->width}),
                         std::min({tile.y1, box_.hi.y, out->y0 + out->height})};
    if (inside.x0 >= inside.x1 || inside.y0 >= inside.y1) return;
    ThinBeams thin(grown_, frame_, inside, slab, bits, base_, out);
    if (width <= 8 && height <= 8) {
        grown_.collect(box, &tools->gathered, &thin);
    } else if (!grown_.collect_few(box, kFew, &tools->gathered, &thin) && !grown_.failed()) {
        const auto half = [](int32_t side) { return (side / 2 + 7) & ~7; };
        Columns one = tile, other = tile;
        if (width >= height) {
            one.x1 = other.x0 = tile.x0 + half(width);
        } else {
            one.y1 = other.y0 = tile.y0 + half(height);
        }
        cover_tile(slab, one, stop, tools, out);
        return cover_tile(slab, other, stop, tools, out);
    }
    if (tools->gathered.beams.empty()) return;
    tools->local.set(tools->gathered, grown_.center(), nullptr);
    if (!tools->local.empty()) {
        BeamCoverage(tools->local.tree(), frame_, box_, base_)
            .cover(slab, tile, stop, &tools->of_beams, out);
    }
    if (tools->gathered.bodies.empty()) return;
    std::vector<BodyBox> bodies;
    for (const GrownBeam& place : tools->gathered.beams) {
        if (place.body >= 0)
            bodies.push_back({&tools->gathered.bodies[static_cast<size_t>(place.body)],
                              {place.end[0], place.end[1]}});
    }
    for (int32_t left = tile.x0; left < tile.x1; left += kLargest)
        cover_bodies(slab, {left, tile.y0}, kLargest, bodies, tile, out);
}

/// In tiles that are halved while a body's box touches them.
void GrowCoverage::cover_bodies(int32_t slab, std::array<int32_t, 2> at, int32_t side,
                                std::span<const BodyBox> bodies, const Columns& columns,
                                voxel::SlabMask* out) const {
    const Vec3i lowest = Vec3i{at[0], at[1], kSlabSlices * slab} - base_;
    const Box3f box = frame_.box(lowest, lowest + Vec3i{side - 1, side - 1, kSlabSlices - 1});
    const float margin = grown_.slack(box.hi, 0);
    Box3f here;  // part space
    for (int a = 0; a < 3; ++a) {
        const auto center = static_cast<float>(grown_.center()[a]);
        here.lo[a] = box.lo[a] + center - margin;
        here.hi[a] = box.hi[a] + center + margin;
    }
    std::vector<BodyBox> touching;
    for (const BodyBox& body : bodies) {
        if (body.box.overlaps(here)) touching.push_back(body);
    }
    if (touching.empty()) return;
    if (side == kSlabSlices) return cover_block(slab, at, touching, out);
    const int32_t half = side / 2;
    for (int32_t k = 0; k < 4; ++k) {
        const std::array<int32_t, 2> to{at[0] + (k & 1) * half, at[1] + (k >> 1) * half};
        if (to[0] < columns.x1 && to[1] < columns.y1)
            cover_bodies(slab, to, half, touching, columns, out);
    }
}

void GrowCoverage::cover_block(int32_t slab, std::array<int32_t, 2> at,
                               std::span<const BodyBox> bodies, voxel::SlabMask* out) const {
    const Vec3i from{at[0], at[1], kSlabSlices * slab};
    const VoxelBall ball = voxel_ball(frame_, from - base_, {8, 8, 8});
    const Vec3d middle = vec_cast<double>(ball.middle) + grown_.center();
    const uint32_t slices = slices_in(box_, slab);
    const int32_t x1 = std::min({from.x + 8, box_.hi.x, out->x0 + out->width});
    const int32_t y1 = std::min({from.y + 8, box_.hi.y, out->y0 + out->height});
    const auto bits = [&](int32_t x, int32_t y) -> uint8_t& {
        return out->mask[static_cast<size_t>(y - out->y0) * static_cast<size_t>(out->width) +
                         static_cast<size_t>(x - out->x0)];
    };
    std::vector<Vec3d> points;
    std::vector<Vec3i> voxels;
    std::vector<Standing::Found> found;
    for (const BodyBox& one : bodies) {
        const float d = one.body->distance(middle);
        const float reach = ball.radius + grown_.slack(ball.middle, std::fabs(d) + ball.radius);
        if (d > reach) continue;
        const bool all = d < 0.0f - reach;
        points.clear();
        voxels.clear();
        for (int32_t y = std::max(from.y, box_.lo.y); y < y1; ++y) {
            for (int32_t x = std::max(from.x, box_.lo.x); x < x1; ++x) {
                uint8_t& column = bits(x, y);
                if (all) column |= static_cast<uint8_t>(slices);
                for (int32_t z = 0; z < kSlabSlices; ++z) {
                    if ((slices & ~uint32_t{column} & 1u << z) == 0) continue;
                    const Vec3i voxel{x, y, from.z + z};
                    const Vec3f p = frame_.box(voxel - base_, voxel - base_).lo;
                    points.push_back(vec_cast<double>(p) + grown_.center());
                    voxels.push_back(voxel);
                }
            }
        }
        if (points.empty()) continue;
        one.body->ask(points, false, &found);
        for (size_t i = 0; i < points.size(); ++i) {
            if (found[i].distance < 0)
                bits(voxels[i].x, voxels[i].y) |= static_cast<uint8_t>(1u << (voxels[i].z & 7));
        }
    }
}

}  // namespace openfab::solid
