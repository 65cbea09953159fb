// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "base/clock.h"
#include "base/stage_timer.h"

namespace openfab::solid {

namespace {

constexpr int32_t kSlabSlices = 8;
constexpr int32_t kLargest = 64;  // voxels along a side of what intervals decide at once
constexpr size_t kBatch = 8;      // blocks that are evaluated at once

struct Tile {
    Vec2<int32_t> at;  ///< lowest voxel of the grid, in x and y
    int32_t side = 0;
};

/// Returns the bits of a slab's slices within [lo, hi).
uint8_t slices(int32_t slab, int32_t lo, int32_t hi) {
    uint32_t bits = 0;
    for (int32_t z = 0; z < kSlabSlices; ++z)
        bits |= (kSlabSlices * slab + z >= lo && kSlabSlices * slab + z < hi) ? 1u << z : 0u;
    return static_cast<uint8_t>(bits);
}

bool holds(const Box3f& box, const Box3f& other) {
    for (int a = 0; a < 3; ++a) {
        if (!(other.lo[a] >= box.lo[a] && other.hi[a] <= box.hi[a])) return false;
    }
    return true;
}

}  // namespace

void ShapeCoverage::coverage(int32_t slab, voxel::SlabMask* out, const std::atomic<bool>* stop,
                             double* seconds) const {
    out->x0 = out->y0 = out->width = out->height = 0;
    out->mask.clear();
    const int32_t z0 = kSlabSlices * slab;
    if (z0 + kSlabSlices <= box_.lo.z || z0 >= box_.hi.z || box_.lo.x >= box_.hi.x ||
        box_.lo.y >= box_.hi.y)
        return;
    out->x0 = box_.lo.x & ~7, out->y0 = box_.lo.y & ~7;
    out->width = ((box_.hi.x + 7) & ~7) - out->x0;
    out->height = ((box_.hi.y + 7) & ~7) - out->y0;
    out->mask.assign(static_cast<size_t>(out->width) * static_cast<size_t>(out->height), 0);
    const int32_t strips = (out->height + kLargest - 1) / kLargest;
    std::atomic<double> taken{0};
    tbb::parallel_for(0, strips, [&](int32_t strip) {
        double mine = 0;
        {
            const StageTimer timer(Stage::kCoverage, &mine);
            ShapeCalls* calls = field_.take();
            const int32_t y0 = out->y0 + kLargest * strip;
            cover(
                slab,
                {out->x0, y0, out->x0 + out->width, std::min(y0 + kLargest, out->y0 + out->height)},
                calls, stop, out);
            field_.give(calls);
        }
        taken += mine;
    });
    if (seconds != nullptr) *seconds += taken;
}

void ShapeCoverage::cover(int32_t slab, const Columns& columns, ShapeCalls* calls,
                          const std::atomic<bool>* stop, voxel::SlabMask* out) const {
    const uint8_t bits = slices(slab, box_.lo.z, box_.hi.z);
    const Box3f whole = field_.bounds();
    std::vector<Tile> open, next;
    for (int32_t y = columns.y0; y < columns.y1; y += kLargest) {
        for (int32_t x = columns.x0; x < columns.x1; x += kLargest)
            open.push_back({{x, y}, kLargest});
    }
    std::vector<Vec2<int32_t>> undecided;
    ShapePoints lo, hi;
    std::vector<float> value_lo, value_hi;
    for (int32_t side = kLargest; !open.empty(); side /= 2) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
        lo.clear();
        hi.clear();
        for (const Tile& tile : open) {
            const Vec3i lowest{tile.at.x, tile.at.y, kSlabSlices * slab};
            const Box3f box = frame_.box(
                lowest - base_, lowest - base_ + Vec3i{side - 1, side - 1, kSlabSlices - 1});
            lo.push_back(box.lo);
            hi.push_back(box.hi);
        }
        if (const abi::KernelStatus status = calls->bounds(lo, hi, &value_lo, &value_hi);
            !status.ok())
            return field_.note(status);
        next.clear();
        for (size_t i = 0; i < open.size(); ++i) {
            if (value_lo[i] >= 0) continue;
            const Vec2<int32_t> at = open[i].at;
            if (value_hi[i] < 0 && holds(whole, {lo.point(i), hi.point(i)})) {
                const int32_t x0 = std::max(at.x, box_.lo.x), x1 = std::min(at.x + side, box_.hi.x);
                const int32_t y0 = std::max(at.y, box_.lo.y), y1 = std::min(at.y + side, box_.hi.y);
                for (int32_t y = y0; y < y1; ++y) {
                    uint8_t* row = &out->mask[static_cast<size_t>(y - out->y0) *
                                              static_cast<size_t>(out->width)];
                    for (int32_t x = x0; x < x1; ++x)
                        row[x - out->x0] = bits;
                }
                continue;
            }
            if (side == 8) {
                undecided.push_back(at);
                continue;
            }
            const int32_t half = side / 2;
            for (int32_t k = 0; k < 4; ++k) {
                const Vec2<int32_t> part{at.x + (k & 1) * half, at.y + (k >> 1) * half};
                if (part.x < columns.x1 && part.y < columns.y1) next.push_back({part, half});
            }
        }
        open.swap(next);
    }
    for (size_t first = 0; first < undecided.size(); first += kBatch) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
        const size_t end = std::min(first + kBatch, undecided.size());
        evaluate(slab,
                 {undecided.begin() + static_cast<ptrdiff_t>(first),
                  undecided.begin() + static_cast<ptrdiff_t>(end)},
                 calls, out);
    }
}

void ShapeCoverage::evaluate(int32_t slab, const std::vector<Vec2<int32_t>>& blocks,
                             ShapeCalls* calls, voxel::SlabMask* out) const {
    const uint8_t bits = slices(slab, box_.lo.z, box_.hi.z);
    const Box3f whole = field_.bounds();
    const float z0 = static_cast<float>(kSlabSlices * slab - base_.z) + 0.5f;
    ShapePoints points;
    points.resize(blocks.size() * 512);
    for (size_t a = 0; a < 3; ++a) {
        float* to = points.at[a].data();
        for (const Vec2<int32_t>& block : blocks) {
            for (int32_t y = 0; y < 8; ++y) {
                const float fy = static_cast<float>(block.y + y - base_.y) + 0.5f;
                for (int32_t x = 0; x < 8; ++x) {
                    const float fx = static_cast<float>(block.x + x - base_.x) + 0.5f;
                    for (int32_t z = 0; z < 8; ++z)
                        to[z] = frame_.centre(a, fx, fy, z0 + static_cast<float>(z));
                    to += 8;
                }
            }
        }
    }
    std::vector<float> values;
    if (const abi::KernelStatus status = calls->values(points, &values); !status.ok())
        return field_.note(status);
    for (size_t b = 0; b < blocks.size(); ++b) {
        for (int32_t column = 0; column < 64; ++column) {
            const int32_t x = blocks[b].x + column % 8, y = blocks[b].y + column / 8;
            if (x < box_.lo.x || x >= box_.hi.x || y < box_.lo.y || y >= box_.hi.y) continue;
            uint32_t inside = 0;
            for (size_t z = 0; z < 8; ++z) {
                const size_t i = 512 * b + 8 * static_cast<size_t>(column) + z;
                const float v = values[i];
                bool in = v < 0;
                for (size_t a = 0; a < 3; ++a) {
                    const float p = points.at[a][i];
                    in = in && p >= whole.lo[static_cast<int>(a)] &&
                         p <= whole.hi[static_cast<int>(a)];
                }
                inside |= (in ? 1u : 0u) << z;
                if (std::isnan(v)) field_.note_nan(points.point(i));
            }
            out->mask[static_cast<size_t>(y - out->y0) * static_cast<size_t>(out->width) +
                      static_cast<size_t>(x - out->x0)] = static_cast<uint8_t>(inside & bits);
        }
    }
}

void ShapeCoverage::raise_tops(const Columns& columns, TopRows* rows) const {
    ShapeCalls* calls = field_.take();
    voxel::SlabMask mask;
    mask.x0 = columns.x0 & ~7, mask.y0 = columns.y0 & ~7;
    mask.width = ((columns.x1 + 7) & ~7) - mask.x0;
    mask.height = ((columns.y1 + 7) & ~7) - mask.y0;
    const auto size = static_cast<size_t>(mask.width) * static_cast<size_t>(mask.height);
    std::vector<uint8_t> done(size, 0);
    size_t left = columns.count();
    for (int32_t slab = (box_.hi.z - 1) / kSlabSlices; slab >= box_.lo.z / kSlabSlices && left > 0;
         --slab) {
        mask.mask.assign(size, 0);
        cover(slab, {mask.x0, mask.y0, mask.x0 + mask.width, mask.y0 + mask.height}, calls, nullptr,
              &mask);
        for (int32_t y = columns.y0; y < columns.y1; ++y) {
            for (int32_t x = columns.x0; x < columns.x1; ++x) {
                const size_t i =
                    static_cast<size_t>(y - mask.y0) * static_cast<size_t>(mask.width) +
                    static_cast<size_t>(x - mask.x0);
                if (mask.mask[i] == 0 || done[i] != 0) continue;
                done[i] = 1;
                --left;
                int32_t top = 7;
                while ((mask.mask[i] >> top & 1) == 0)
                    --top;
                rows->raise(x, y, kSlabSlices * slab + top);
            }
        }
    }
    field_.give(calls);
}

}  // namespace openfab::solid
