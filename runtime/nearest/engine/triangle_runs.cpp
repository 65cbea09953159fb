// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/engine/triangle_runs.h"

#include <algorithm>

namespace openfab::nearest {

const std::vector<Box3f>& TriangleRuns::of(const surface::Surface& surface, int32_t patch,
                                           std::shared_ptr<const surface::MicroMesh>* mesh) {
    if (kept_.empty()) kept_.resize(kPatches);
    Kept& kept = kept_[static_cast<size_t>(patch) % kPatches];
    if (kept.patch == patch) return kept.boxes;
    *mesh = surface.micro(patch);
    const std::vector<std::array<int32_t, 3>>& triangles = (*mesh)->triangles;
    const Vec3f* positions = (*mesh)->positions.data();
    kept.patch = patch;
    kept.boxes.clear();
    for (size_t first = 0; first < triangles.size(); first += kTriangles) {
        Box3f box;
        for (size_t t = first; t < std::min(first + kTriangles, triangles.size()); ++t) {
            for (const int32_t v : triangles[t])
                box.add(positions[v]);
        }
        kept.boxes.push_back(box);
    }
    return kept.boxes;
}

}  // namespace openfab::nearest
