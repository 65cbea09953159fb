// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Splitting of many boxes by the surface area heuristic, for building trees and for partitioning
// triangles into treelets.

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "base/infinity.h"
#include "base/vec.h"

namespace openfab::nearest {

typedef float F4 __attribute__((vector_size(16)));
typedef int32_t I4 __attribute__((vector_size(16)));

inline F4 lower(F4 a, F4 b) {
    return a < b ? a : b;
}
inline F4 upper(F4 a, F4 b) {
    return a > b ? a : b;
}

/// A box in two registers; the fourth lanes are unspecified.
struct Range {
    F4 lo, hi;

    Range() {
        lo = F4{kInfinity, kInfinity, kInfinity, kInfinity};
        hi = -lo;
    }
    void add(F4 point) {
        lo = lower(lo, point);
        hi = upper(hi, point);
    }
    void add(const Range& r) {
        lo = lower(lo, r.lo);
        hi = upper(hi, r.hi);
    }
    Box3f box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
};

/// A box with the index of its content and the number of triangles it counts for.
struct alignas(16) Item {
    Vec3f lo;
    int32_t index;
    Vec3f hi;
    uint32_t weight;

    Range range() const {
        I4 bits_lo, bits_hi;
        std::memcpy(&bits_lo, &lo, sizeof bits_lo);
        std::memcpy(&bits_hi, &hi, sizeof bits_hi);
        // Small integers are subnormal as floats: sums and products of them take a hundred times
        // as long.
        const I4 three = {-1, -1, -1, 0};
        Range r;
        r.lo = reinterpret_cast<F4>(bits_lo & three);
        r.hi = reinterpret_cast<F4>(bits_hi & three);
        return r;
    }
    F4 centroid() const {
        const Range r = range();
        return (r.lo + r.hi) * 0.5f;
    }
    Box3f box() const { return {lo, hi}; }
};

/// The box of items, the box of their centroids, and their total weight.
struct Extent {
    Range boxes, centroids;
    size_t weight = 0;

    void add(const Item& item) {
        boxes.add(item.range());
        centroids.add(item.centroid());
        weight += item.weight;
    }
    void add(const Extent& e) {
        boxes.add(e.boxes);
        centroids.add(e.centroids);
        weight += e.weight;
    }
};

/// Ranges of more items are processed in parallel. Boxes and counts do not depend on the order.
constexpr size_t kParallel = 16384;

/// Calls add(begin, end, &sum) for parts of a range, in parallel if it is long, and adds up the
/// sums.
template <typename Sum, typename Add>
void sum_up(size_t begin, size_t end, const Add& add, Sum* sum) {
    if (end - begin <= 4 * kParallel) {
        add(begin, end, sum);
        return;
    }
    *sum = tbb::parallel_reduce(
        tbb::blocked_range<size_t>(begin, end, kParallel), *sum,
        [&](const auto& range, Sum part) {
            add(range.begin(), range.end(), &part);
            return part;
        },
        [](Sum a, const Sum& b) {
            a.add(b);
            return a;
        });
}

/// Returns half the surface area of the box.
inline float half_area(const Box3f& b) {
    const Vec3f s = b.size();
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

/// Returns the extent of a range of items.
Extent extent_of(const std::vector<Item>& items, size_t begin, size_t end);

/// Partitions a range of at least two items by the surface area heuristic, or halves it if all
/// centroids coincide. Returns where the second side begins and fills the extents of both sides.
size_t split_items(const Extent& extent, size_t begin, size_t end, std::vector<Item>* items,
                   Extent sides[2]);

}  // namespace openfab::nearest
