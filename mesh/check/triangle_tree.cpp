// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/triangle_tree.h"

#include <algorithm>
#include <utility>

namespace openfab::mesh {

TriangleTree::TriangleTree(const Mesh& mesh) : boxes_(mesh.triangles.size()) {
    std::vector<Center> centers(boxes_.size());
    for (size_t t = 0; t < boxes_.size(); ++t) {
        for (int32_t v : mesh.triangles[t])
            boxes_[t].add(mesh.positions[v]);
        centers[t] = {boxes_[t].center(), static_cast<int32_t>(t)};
    }
    if (centers.empty()) return;
    nodes_.reserve(boxes_.size());
    nodes_.push_back({});
    split(0, 0, centers);
    order_.reserve(centers.size());
    for (const Center& c : centers)
        order_.push_back(c.triangle);
}

// Splits at the median, so that the depth is logarithmic for any mesh.
void TriangleTree::split(size_t node, int32_t first, std::span<Center> centers) {
    constexpr size_t kLeaf = 4;
    Box3d whole;
    Box3d spread;
    for (const Center& c : centers) {
        whole.add(box(c.triangle));
        spread.add(c.at);
    }
    nodes_[node] = {whole, first, static_cast<int32_t>(centers.size()), centers.size() <= kLeaf};
    if (nodes_[node].leaf) return;
    const Vec3d size = spread.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t half = centers.size() / 2;
    std::nth_element(centers.begin(), centers.begin() + static_cast<std::ptrdiff_t>(half),
                     centers.end(), [&](const Center& a, const Center& b) {
                         return std::pair(a.at[axis], a.triangle) <
                                std::pair(b.at[axis], b.triangle);
                     });
    const size_t children = nodes_.size();
    nodes_[node].first = static_cast<int32_t>(children);
    nodes_.resize(children + 2);
    split(children, first, centers.first(half));
    split(children + 1, first + static_cast<int32_t>(half), centers.subspan(half));
}

}  // namespace openfab::mesh
