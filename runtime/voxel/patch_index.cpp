// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/voxel/patch_index.h"

#include <algorithm>

namespace openfab::voxel {

PatchIndex::PatchIndex(const surface::Surface& surface) {
    const std::vector<surface::Patch>& patches = surface.patches();
    std::vector<Vec3f> centres;
    for (size_t p = 0; p < patches.size(); ++p) {
        centres.push_back(patches[p].bounds.center());
        if ((patches[p].use & surface::kForCoverage) != 0)
            patches_.push_back(static_cast<int32_t>(p));
    }
    if (patches_.empty()) return;
    nodes_.push_back({{}, 0, static_cast<int32_t>(patches_.size()), 0});
    build(0, patches, centres);
    nodes_.shrink_to_fit();
}

void PatchIndex::build(size_t node, const std::vector<surface::Patch>& patches,
                       const std::vector<Vec3f>& centres) {
    const int32_t first = nodes_[node].first, end = nodes_[node].end;
    Box3f box, middles;
    for (int32_t i = first; i < end; ++i) {
        const auto p = static_cast<size_t>(patches_[static_cast<size_t>(i)]);
        box.add(patches[p].bounds);
        middles.add(centres[p]);
    }
    nodes_[node].box = box;
    if (end - first <= kLeafPatches) return;
    const Vec3f size = middles.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int32_t middle = first + (end - first) / 2;
    // The middle by number, whatever the boxes: the depth is bounded, and equal centres do no harm.
    std::nth_element(patches_.begin() + first, patches_.begin() + middle, patches_.begin() + end,
                     [&](int32_t a, int32_t b) {
                         const float ca = centres[static_cast<size_t>(a)][axis];
                         const float cb = centres[static_cast<size_t>(b)][axis];
                         return ca != cb ? ca < cb : a < b;
                     });
    const size_t child = nodes_.size();
    nodes_[node].child = static_cast<int32_t>(child);
    nodes_.push_back({{}, first, middle, 0});
    nodes_.push_back({{}, middle, end, 0});
    build(child, patches, centres);
    build(child + 1, patches, centres);
}

}  // namespace openfab::voxel
