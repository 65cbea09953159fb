// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/patch_index.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>

#include "runtime/surface/morton_order.h"

namespace openfab::voxel {
namespace {

/// More patches than this are processed in parallel.
constexpr size_t kParallel = 16384;

}  // namespace

struct PatchIndex::Builder {
    /// Returns the number of nodes of a tree over `size` patches: sizes of the nodes of one level
    /// differ by at most one.
    static size_t node_count(size_t size) {
        size_t total = 0;
        size_t small = 1, large = 0;  // nodes of `size` patches, and of one more
        while (small + large > 0) {
            total += small + large;
            const size_t splits_small = size > kLeafPatches ? small : 0;
            const size_t splits_large = size + 1 > kLeafPatches ? large : 0;
            // An even size halves into two equal ones, an odd one into two that differ.
            const bool even = size % 2 == 0;
            small = even ? 2 * splits_small + splits_large : splits_small;
            large = even ? splits_large : splits_small + 2 * splits_large;
            size /= 2;
        }
        return total;
    }

    void build(size_t node, size_t first, size_t end) {
        nodes[node].first = static_cast<int32_t>(first);
        nodes[node].end = static_cast<int32_t>(end);
        Box3f box;
        if (end - first <= kLeafPatches) {
            for (size_t i = first; i < end; ++i)
                box.add(patches[order[i]].bounds);
            nodes[node].box = box;
            return;
        }
        // Split by count, independently of the boxes, so that the depth is bounded.
        const size_t middle = first + (end - first) / 2;
        const size_t child = used.fetch_add(2);
        nodes[node].child = static_cast<int32_t>(child);
        if (end - first > kParallel) {
            tbb::parallel_invoke([&] { build(child, first, middle); },
                                 [&] { build(child + 1, middle, end); });
        } else {
            build(child, first, middle);
            build(child + 1, middle, end);
        }
        box.add(nodes[child].box);
        box.add(nodes[child + 1].box);
        nodes[node].box = box;
    }

    const std::vector<surface::Patch>& patches;
    const std::vector<int32_t>& order;
    std::vector<Node>& nodes;
    std::atomic<size_t> used{1};
};

PatchIndex::PatchIndex(const surface::Surface& surface)
    : PatchIndex(surface, surface::morton_order(surface.patches())) {}

PatchIndex::PatchIndex(const surface::Surface& surface, std::span<const uint64_t> morton) {
    // Halving the Morton order is about as good as halving by the longest axis, in a tenth of the
    // time.
    patches_.reserve(morton.size());
    const bool all = surface.identity();
    for (const uint64_t item : morton) {
        const auto patch = static_cast<int32_t>(item & 0xffffffffu);
        if (all || (surface.patches()[patch].use & surface::kForCoverage) != 0)
            patches_.push_back(patch);
    }
    if (patches_.empty()) return;
    nodes_.resize(Builder::node_count(patches_.size()));
    Builder builder{surface.patches(), patches_, nodes_};
    builder.build(0, 0, patches_.size());
}

}  // namespace openfab::voxel
