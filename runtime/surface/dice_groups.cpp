// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/dice_groups.h"

#include <algorithm>

#include "runtime/surface/morton_order.h"

namespace openfab::surface {
namespace {

/// Patches of more micropolygons, or with more points than their lattices have cells, are in no group.
constexpr int32_t kSmall = 64;
/// Most micropolygons of a group: no more than those of a small tile, so that what is diced without
/// being asked for is little, however small the cache.
constexpr int32_t kGroupTriangles = 256;
/// Longest side of a group beyond that of its patches, in micro-edges.
constexpr float kLongest = 24;

/// The number of micropolygons of a lattice patch at most.
int32_t triangles_of(const Patch& patch) {
    const auto [a0, b0, a1, b1] = patch.lattice;
    int32_t count = 0;
    for (int32_t b = b0; b < b1; ++b)
        count += 2 * (std::min(a1, patch.factor - b) - a0);
    return count;
}

}  // namespace

DiceGroups::DiceGroups(const std::vector<Patch>& patches, double micro_edge_mm) {
    const auto is_small = [](const Patch& patch) {
        return patch.kind == PatchKind::kLattice && patch.factor <= kSmall &&
               triangles_of(patch) <= kSmall;
    };
    if (std::ranges::count_if(patches, is_small) < 2) return;
    groups_.assign(patches.size(), kNone);
    const float longest = kLongest * static_cast<float>(micro_edge_mm);
    int32_t triangles = 0;
    float largest = 0;
    Box3f box;
    const auto end_group = [&] {
        if (order_.size() == first_.back()) return;
        first_.push_back(static_cast<uint32_t>(order_.size()));
        triangles = 0;
        largest = 0;
        box = {};
    };
    for (const uint64_t item : morton_order(patches)) {
        const auto p = static_cast<int32_t>(item & 0xffffffffu);
        const Patch& patch = patches[static_cast<size_t>(p)];
        if (!is_small(patch)) continue;
        Box3f with = box;
        with.add(patch.bounds);
        const float most = std::max(largest, patch.bounds.longest_side());
        const int32_t more = triangles_of(patch);
        if (triangles + more > kGroupTriangles || with.longest_side() > longest + most) end_group();
        box.add(patch.bounds);
        largest = std::max(largest, patch.bounds.longest_side());
        triangles += more;
        groups_[static_cast<size_t>(p)] = static_cast<uint32_t>(first_.size() - 1);
        order_.push_back(p);
    }
    end_group();
}

}  // namespace openfab::surface
