// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/split.h"

#include <algorithm>
#include <utility>

#include "base/infinity.h"

namespace openfab::nearest {
namespace {

/// Returns half the surface area of a box of this size; the fourth lane is ignored.
float half_area(F4 size) {
    const F4 turned = __builtin_shufflevector(size, size, 1, 2, 0, 3);
    const F4 sides = size * turned;
    return (sides[0] + sides[1]) + sides[2];
}

/// Maps a centroid to one of kBins bins along each axis.
template <int kBins>
struct Binning {
    F4 lo, scale;

    explicit Binning(const Range& centroids) : lo(centroids.lo) {
        const F4 extent = centroids.hi - centroids.lo;
        for (int axis = 0; axis < 4; ++axis) {
            // An axis so thin that its inverse is not finite has one bin.
            const bool wide = axis < 3 && extent[axis] > std::numeric_limits<float>::min();
            scale[axis] = wide ? static_cast<float>(kBins) / extent[axis] : 0;
        }
    }
    I4 bins(F4 centroid) const {
        const F4 b = (centroid - lo) * scale;
        // Clamped before conversion to integer: the fourth lane is unspecified.
        const F4 most = {kBins - 1, kBins - 1, kBins - 1, kBins - 1};
        const F4 at_least_0 = upper(b, F4{0, 0, 0, 0});
        return __builtin_convertvector(lower(at_least_0, most), I4);
    }
};

template <int kBins>
struct Bins {
    Range boxes[3][kBins];
    uint32_t counts[3][kBins] = {};

    void add(const Bins& other) {
        for (int axis = 0; axis < 3; ++axis) {
            for (int b = 0; b < kBins; ++b) {
                boxes[axis][b].add(other.boxes[axis][b]);
                counts[axis][b] += other.counts[axis][b];
            }
        }
    }
};

/// Returns axis and last bin of the left side of the cheapest split; axis -1 if there is none.
template <int kBins>
std::pair<int, int> cheapest_split(const Bins<kBins>& bins, const Range& centroids, size_t count) {
    float best_cost = kInfinity;
    std::pair<int, int> best{-1, 0};
    for (int axis = 0; axis < 3; ++axis) {
        if (!(centroids.hi[axis] - centroids.lo[axis] > 0)) continue;
        // An empty bin does not change the two sides.
        float right_cost[kBins + 1] = {};
        Range right;
        size_t n = 0;
        for (int b = kBins - 1; b > 0; --b) {
            right_cost[b] = right_cost[b + 1];
            if (bins.counts[axis][b] == 0) continue;
            right.add(bins.boxes[axis][b]);
            n += bins.counts[axis][b];
            right_cost[b] = half_area(right.hi - right.lo) * static_cast<float>(n);
        }
        Range left;
        n = 0;
        for (int b = 0; b + 1 < kBins; ++b) {
            if (bins.counts[axis][b] == 0) continue;
            left.add(bins.boxes[axis][b]);
            n += bins.counts[axis][b];
            if (n == count) break;
            const float cost =
                half_area(left.hi - left.lo) * static_cast<float>(n) + right_cost[b + 1];
            if (cost < best_cost) {
                best_cost = cost;
                best = {axis, b};
            }
        }
    }
    return best;
}

template <int kBins>
size_t split_by_bins(const Extent& extent, size_t begin, size_t end, std::vector<Item>* items,
                     Extent sides[2]) {
    const Binning<kBins> binning(extent.centroids);
    Bins<kBins> bins;
    const auto add = [&](size_t first, size_t last, Bins<kBins>* sum) {
        for (size_t i = first; i < last; ++i) {
            const Item& item = (*items)[i];
            const Range range = item.range();
            const I4 b = binning.bins(item.centroid());
            for (int axis = 0; axis < 3; ++axis) {
                sum->boxes[axis][b[axis]].add(range);
                sum->counts[axis][b[axis]] += item.weight;
            }
        }
    };
    sum_up(begin, end, add, &bins);
    const auto [axis, bin] = cheapest_split(bins, extent.centroids, extent.weight);
    if (axis >= 0) {
        const auto first = items->begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = items->begin() + static_cast<std::ptrdiff_t>(end);
        const auto it = std::partition(first, last, [&, axis = axis, bin = bin](const Item& i) {
            const bool left = binning.bins(i.centroid())[axis] <= bin;
            sides[left ? 0 : 1].add(i);
            return left;
        });
        const auto middle = static_cast<size_t>(it - items->begin());
        if (middle != begin && middle != end) return middle;
    }
    const size_t middle = begin + (end - begin) / 2;
    sides[0] = extent_of(*items, begin, middle);
    sides[1] = extent_of(*items, middle, end);
    return middle;
}

/// Up to this many items are sorted along each axis: faster than bins, and exact.
constexpr size_t kMaxSorted = 16;

size_t split_few(size_t begin, size_t end, std::vector<Item>* items, Extent sides[2]) {
    const size_t n = end - begin;
    Item* list = items->data() + begin;
    uint8_t order[3][kMaxSorted];
    float best_cost = kInfinity;
    size_t best_axis = 0, best_count = n / 2;
    for (size_t axis = 0; axis < 3; ++axis) {
        float along[kMaxSorted];
        for (size_t i = 0; i < n; ++i) {
            const float at = list[i].centroid()[axis];
            size_t k = i;
            for (; k > 0 && at < along[k - 1]; --k) {
                along[k] = along[k - 1];
                order[axis][k] = order[axis][k - 1];
            }
            along[k] = at;
            order[axis][k] = static_cast<uint8_t>(i);
        }
        float right_cost[kMaxSorted];
        Range right, left;
        uint32_t weight = 0;
        for (size_t k = n; k-- > 1;) {
            right.add(list[order[axis][k]].range());
            weight += list[order[axis][k]].weight;
            right_cost[k] = half_area(right.hi - right.lo) * static_cast<float>(weight);
        }
        weight = 0;
        for (size_t k = 0; k + 1 < n; ++k) {
            left.add(list[order[axis][k]].range());
            weight += list[order[axis][k]].weight;
            const float cost =
                half_area(left.hi - left.lo) * static_cast<float>(weight) + right_cost[k + 1];
            if (cost < best_cost) {
                best_cost = cost;
                best_axis = axis;
                best_count = k + 1;
            }
        }
    }
    Item sorted[kMaxSorted];
    for (size_t k = 0; k < n; ++k) {
        sorted[k] = list[order[best_axis][k]];
        sides[k < best_count ? 0 : 1].add(sorted[k]);
    }
    std::copy(sorted, sorted + n, list);
    return begin + best_count;
}

}  // namespace

Extent extent_of(const std::vector<Item>& items, size_t begin, size_t end) {
    Extent extent;
    const auto add = [&](size_t first, size_t last, Extent* sum) {
        for (size_t i = first; i < last; ++i)
            sum->add(items[i]);
    };
    sum_up(begin, end, add, &extent);
    return extent;
}

size_t split_items(const Extent& extent, size_t begin, size_t end, std::vector<Item>* items,
                   Extent sides[2]) {
    if (end - begin <= kMaxSorted) return split_few(begin, end, items, sides);
    if (end - begin <= 64) return split_by_bins<8>(extent, begin, end, items, sides);
    return split_by_bins<16>(extent, begin, end, items, sides);
}

}  // namespace openfab::nearest
