// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/shape/shape_coverage.h"

#include <algorithm>
#include <bit>
#include <span>

#include "runtime/solid/coverage_strips.h"
#include "simd/intrinsics.h"

namespace openfab::solid {

namespace {

// Columns along a side of what intervals decide at the end: worth a tenth of the points that are left by twice as large
// ones.
constexpr int32_t kSmallest = 4;
constexpr int32_t kColumns = kSmallest * kSmallest;
constexpr size_t kPoints = static_cast<size_t>(kColumns) * kSlabSlices;
constexpr size_t kBatch = 32;  // of the smallest, that are evaluated at once

/// Eight values, in order, one for each slice. Every set has these registers.
struct Eight {
    __m128 low, high;
    explicit Eight(const float* p) : low(_mm_loadu_ps(p)), high(_mm_loadu_ps(p + 4)) {}
};
uint32_t bits(__m128 low, __m128 high) {
    return static_cast<uint32_t>(_mm_movemask_ps(low)) |
           static_cast<uint32_t>(_mm_movemask_ps(high)) << 4;
}
uint32_t within(const Eight& v, float lo, float hi) {
    const __m128 least = _mm_set1_ps(lo), most = _mm_set1_ps(hi);
    return bits(_mm_and_ps(_mm_cmpge_ps(v.low, least), _mm_cmple_ps(v.low, most)),
                _mm_and_ps(_mm_cmpge_ps(v.high, least), _mm_cmple_ps(v.high, most)));
}
uint32_t negative(const Eight& v) {
    const __m128 zero = _mm_setzero_ps();
    return bits(_mm_cmplt_ps(v.low, zero), _mm_cmplt_ps(v.high, zero));
}
uint32_t no_number(const Eight& v) {
    return bits(_mm_cmpunord_ps(v.low, v.low), _mm_cmpunord_ps(v.high, v.high));
}

/// How a box lies to the shape's, outside of which nothing is evaluated.
enum class Lies : uint8_t { kInside, kAcross, kOutside };

/// Cuts a box to another; one outside becomes a point.
Lies cut(const Box3f& to, Box3f* box) {
    Lies lies = Lies::kInside;
    for (int a = 0; a < 3; ++a) {
        if (box->hi[a] < to.lo[a] || box->lo[a] > to.hi[a]) {
            box->lo = box->hi = to.lo;
            return Lies::kOutside;
        }
        if (box->lo[a] >= to.lo[a] && box->hi[a] <= to.hi[a]) continue;
        lies = Lies::kAcross;
        box->lo[a] = std::max(box->lo[a], to.lo[a]);
        box->hi[a] = std::min(box->hi[a], to.hi[a]);
    }
    return lies;
}

}  // namespace

void ShapeCoverage::cover(int32_t slab, const Columns& columns, const std::atomic<bool>* stop,
                          Tools* tools, voxel::SlabMask* out) const {
    ShapeCalls* calls = tools->calls;
    const uint8_t all = slices_in(box_, slab);
    const Box3f whole = field_.bounds();
    std::vector<Vec2<int32_t>> open, next;
    for (int32_t y = columns.y0; y < columns.y1; y += kLargest) {
        for (int32_t x = columns.x0; x < columns.x1; x += kLargest)
            open.push_back({x, y});
    }
    std::vector<Vec2<int32_t>> undecided;
    ShapePoints lo, hi;
    std::vector<float> value_lo, value_hi;
    std::vector<Lies> lies;
    for (int32_t side = kLargest; !open.empty(); side /= 2) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
        lo.resize(open.size());
        hi.resize(open.size());
        lies.resize(open.size());
        for (size_t i = 0; i < open.size(); ++i) {
            const Vec3i lowest = Vec3i{open[i].x, open[i].y, kSlabSlices * slab} - base_;
            Box3f box = frame_.box(lowest, lowest + Vec3i{side - 1, side - 1, kSlabSlices - 1});
            lies[i] = cut(whole, &box);
            lo.set(i, box.lo);
            hi.set(i, box.hi);
        }
        if (const abi::KernelStatus status = calls->sign_bounds(lo, hi, &value_lo, &value_hi);
            !status.ok())
            return field_.note(status);
        next.clear();
        for (size_t i = 0; i < open.size(); ++i) {
            if (value_lo[i] >= 0 || lies[i] == Lies::kOutside) continue;
            const Vec2<int32_t> at = open[i];
            if (value_hi[i] < 0 && lies[i] == Lies::kInside) {
                const int32_t x0 = std::max(at.x, box_.lo.x), y0 = std::max(at.y, box_.lo.y);
                const int32_t x1 = std::min({at.x + side, box_.hi.x, columns.x1});
                const int32_t y1 = std::min({at.y + side, box_.hi.y, columns.y1});
                for (int32_t y = y0; y < y1; ++y) {
                    uint8_t* row = &out->mask[static_cast<size_t>(y - out->y0) *
                                              static_cast<size_t>(out->width)];
                    for (int32_t x = x0; x < x1; ++x)
                        row[x - out->x0] = all;
                }
                continue;
            }
            if (side == kSmallest) {
                undecided.push_back(at);
                continue;
            }
            const int32_t half = side / 2;
            for (int32_t k = 0; k < 4; ++k) {
                const Vec2<int32_t> part{at.x + (k & 1) * half, at.y + (k >> 1) * half};
                if (part.x < columns.x1 && part.y < columns.y1) next.push_back(part);
            }
        }
        open.swap(next);
    }
    ShapePoints points;
    std::vector<float> values;
    for (size_t first = 0; first < undecided.size(); first += kBatch) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) return;
        evaluate(slab,
                 std::span(undecided).subspan(first, std::min(kBatch, undecided.size() - first)),
                 calls, &points, &values, out);
    }
}

void ShapeCoverage::evaluate(int32_t slab, std::span<const Vec2<int32_t>> tiles, ShapeCalls* calls,
                             ShapePoints* points, std::vector<float>* values,
                             voxel::SlabMask* out) const {
    const uint8_t all = slices_in(box_, slab);
    const Box3f whole = field_.bounds();
    const float z0 = static_cast<float>(kSlabSlices * slab - base_.z) + 0.5f;
    points->resize(tiles.size() * kPoints);
    for (size_t a = 0; a < 3; ++a) {
        float* to = points->at[a].data();
        for (const Vec2<int32_t>& tile : tiles) {
            for (int32_t y = 0; y < kSmallest; ++y) {
                const float fy = static_cast<float>(tile.y + y - base_.y) + 0.5f;
                for (int32_t x = 0; x < kSmallest; ++x) {
                    const float fx = static_cast<float>(tile.x + x - base_.x) + 0.5f;
                    for (int32_t z = 0; z < kSlabSlices; ++z)
                        to[z] = frame_.centre(a, fx, fy, z0 + static_cast<float>(z));
                    to += kSlabSlices;
                }
            }
        }
    }
    // What lies outside of the shape's box is evaluated on its border, and is void.
    std::array<uint8_t, kBatch * kColumns> in_box;
    for (size_t column = 0; column < tiles.size() * kColumns; ++column) {
        const size_t first = kSlabSlices * column;
        uint32_t in = 0xff;
        for (size_t a = 0; a < 3; ++a) {
            const int axis = static_cast<int>(a);
            in &= within(Eight(points->at[a].data() + first), whole.lo[axis], whole.hi[axis]);
        }
        in_box[column] = static_cast<uint8_t>(in);
        for (size_t a = 0; a < 3 && in != 0xff; ++a) {
            const int axis = static_cast<int>(a);
            for (size_t z = first; z < first + kSlabSlices; ++z)
                points->at[a][z] = std::clamp(points->at[a][z], whole.lo[axis], whole.hi[axis]);
        }
    }
    if (const abi::KernelStatus status = calls->dense_signs(*points, values); !status.ok())
        return field_.note(status);
    for (size_t t = 0; t < tiles.size(); ++t) {
        for (int32_t column = 0; column < kColumns; ++column) {
            const int32_t x = tiles[t].x + column % kSmallest, y = tiles[t].y + column / kSmallest;
            if (x < box_.lo.x || x >= box_.hi.x || y < box_.lo.y || y >= box_.hi.y) continue;
            const size_t first = kPoints * t + kSlabSlices * static_cast<size_t>(column);
            const Eight value(values->data() + first);
            const uint32_t in = in_box[kColumns * t + static_cast<size_t>(column)];
            const uint32_t inside = negative(value) & all & in;
            if (const uint32_t nans = no_number(value) & in; nans != 0)
                field_.note_nan(points->point(first + static_cast<size_t>(std::countr_zero(nans))));
            out->mask[static_cast<size_t>(y - out->y0) * static_cast<size_t>(out->width) +
                      static_cast<size_t>(x - out->x0)] = static_cast<uint8_t>(inside);
        }
    }
}

}  // namespace openfab::solid
