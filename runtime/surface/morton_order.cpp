// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/morton_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>

namespace openfab::surface {
namespace {

/// More patches than this are processed in parallel.
constexpr size_t kParallel = 16384;

/// Spreads ten bits, two zeros before each.
uint32_t spread_bits(uint32_t x) {
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

}  // namespace

std::vector<uint64_t> morton_order(const std::vector<Patch>& patches) {
    std::vector<uint64_t> items;
    items.reserve(patches.size());
    for (size_t p = 0; p < patches.size(); ++p) {
        if (patches[p].use != 0) items.push_back(p);
    }
    const tbb::blocked_range<size_t> all(0, items.size(), kParallel);
    const auto center = [&](size_t i) { return patches[items[i]].bounds.center(); };
    const Box3f centers = tbb::parallel_reduce(
        all, Box3f{},
        [&](const auto& range, Box3f box) {
            for (size_t i = range.begin(); i < range.end(); ++i)
                box.add(center(i));
            return box;
        },
        [](Box3f a, const Box3f& b) {
            a.add(b);
            return a;
        });
    const Vec3f size = centers.size();
    Vec3f scale;
    for (int a = 0; a < 3; ++a)
        scale[a] = size[a] > 0 ? 1023.0f / size[a] : 0;
    tbb::parallel_for(all, [&](const auto& range) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
            const Vec3f c = center(i);
            uint64_t code = 0;
            for (int a = 0; a < 3; ++a) {
                // An empty patch has no center.
                const float along = (c[a] - centers.lo[a]) * scale[a];
                const float at = along > 0 ? std::min(along, 1023.0f) : 0.0f;
                code |= uint64_t{spread_bits(static_cast<uint32_t>(at))} << a;
            }
            items[i] |= code << 32;
        }
    });
    tbb::parallel_sort(items.begin(), items.end());
    return items;
}

}  // namespace openfab::surface
