// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/patch_index.h"

#include <algorithm>

namespace openfab::voxel {

namespace {

const Box3f& bounds_of(const surface::Surface& surface, int32_t patch) {
    return surface.patches()[static_cast<size_t>(patch)].bounds;
}

}  // namespace

PatchIndex::PatchIndex(const surface::Surface& surface) {
    for (size_t p = 0; p < surface.patches().size(); ++p) {
        if ((surface.patches()[p].use & surface::kForCoverage) != 0)
            patches_.push_back(static_cast<int32_t>(p));
    }
    if (patches_.empty()) return;
    nodes_.push_back({{}, 0, static_cast<int32_t>(patches_.size()), 0});
    build(0, surface);
    nodes_.shrink_to_fit();
}

void PatchIndex::build(size_t node, const surface::Surface& surface) {
    const int32_t first = nodes_[node].first, end = nodes_[node].end;
    Box3f box, centres;
    for (int32_t i = first; i < end; ++i) {
        const Box3f& b = bounds_of(surface, patches_[static_cast<size_t>(i)]);
        box.add(b);
        centres.add(b.center());
    }
    nodes_[node].box = box;
    if (end - first <= kLeafPatches) return;
    const Vec3f size = centres.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int32_t middle = first + (end - first) / 2;
    // The middle by number, whatever the boxes: the depth is bounded, and equal centres do no harm.
    std::nth_element(patches_.begin() + first, patches_.begin() + middle, patches_.begin() + end,
                     [&](int32_t a, int32_t b) {
                         const float ca = bounds_of(surface, a).center()[axis];
                         const float cb = bounds_of(surface, b).center()[axis];
                         return ca != cb ? ca < cb : a < b;
                     });
    const size_t child = nodes_.size();
    nodes_[node].child = static_cast<int32_t>(child);
    nodes_.push_back({{}, first, middle, 0});
    nodes_.push_back({{}, middle, end, 0});
    build(child, surface);
    build(child + 1, surface);
}

}  // namespace openfab::voxel
