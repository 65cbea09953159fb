// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/triangle_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace openfab::scene {

TriangleTree::TriangleTree(const Mesh& mesh)
    : boxes_(mesh.triangles.size()), order_(mesh.triangles.size()) {
    for (size_t t = 0; t < boxes_.size(); ++t) {
        for (int32_t v : mesh.triangles[t])
            boxes_[t].add(mesh.positions[static_cast<size_t>(v)]);
    }
    std::iota(order_.begin(), order_.end(), 0);
    if (order_.empty()) return;
    nodes_.reserve(order_.size());
    nodes_.push_back({});
    split(0, 0, static_cast<int32_t>(order_.size()));
}

// By the median, so that the depth is the logarithm whatever the mesh.
void TriangleTree::split(size_t node, int32_t first, int32_t count) {
    constexpr int32_t kLeaf = 4;
    Box3d whole;
    Box3d centers;
    for (int32_t i = first; i < first + count; ++i) {
        const Box3d& b = boxes_[static_cast<size_t>(order_[static_cast<size_t>(i)])];
        whole.add(b);
        centers.add(b.center());
    }
    nodes_[node].box = whole;
    nodes_[node].end = first + count;
    if (count <= kLeaf) {
        nodes_[node].first = first;
        nodes_[node].count = count;
        return;
    }
    const Vec3d size = centers.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int32_t half = count / 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](int32_t a, int32_t b) {
        const double ca = boxes_[static_cast<size_t>(a)].center()[axis];
        const double cb = boxes_[static_cast<size_t>(b)].center()[axis];
        return std::pair(ca, a) < std::pair(cb, b);
    });
    const size_t children = nodes_.size();
    nodes_[node].first = static_cast<int32_t>(children);
    nodes_.resize(children + 2);
    split(children, first, half);
    split(children + 1, first + half, count - half);
}

}  // namespace openfab::scene
