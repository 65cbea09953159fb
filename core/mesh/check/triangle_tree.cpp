// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/triangle_tree.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <utility>

namespace openfab::mesh {

namespace {

constexpr size_t kLeaf = 4;
// Below this a task costs more to hand out than to run.
constexpr size_t kSplitAlone = 2048;

/// Returns the number of nodes of a tree over n triangles. Those of a depth hold `size` triangles or
/// one more.
size_t count_nodes(size_t n) {
    size_t nodes = 0, size = n, plain = 1, larger = 0;
    while (plain + larger > 0) {
        nodes += plain + larger;
        if (size <= kLeaf) plain = 0;
        if (size + 1 <= kLeaf) larger = 0;
        const size_t odd = size % 2 == 1 ? plain : larger;
        const size_t even = size % 2 == 1 ? larger : plain;
        plain = odd + (size % 2 == 1 ? 0 : 2 * even);
        larger = odd + (size % 2 == 1 ? 2 * even : 0);
        size /= 2;
    }
    return nodes;
}

}  // namespace

TriangleTree::TriangleTree(const Mesh& mesh) {
    const size_t count = mesh.triangles.size();
    if (count == 0) return;
    std::vector<Center> centers;
    // The first touch of fresh memory takes longer than what is done with it.
    tbb::parallel_invoke([&] { boxes_.resize(count); }, [&] { centers.resize(count); },
                         [&] { nodes_.resize(count_nodes(count)); }, [&] { order_.resize(count); });
    const auto range = tbb::blocked_range<size_t>(0, count, kSplitAlone);
    tbb::parallel_for(range, [&](const tbb::blocked_range<size_t>& some) {
        for (size_t t = some.begin(); t < some.end(); ++t) {
            for (int32_t v : mesh.triangles[t])
                boxes_[t].add(mesh.positions[v]);
            centers[t] = {boxes_[t].center(), static_cast<int32_t>(t)};
        }
    });
    const size_t used = split(0, 0, centers, 1);
    OPENFAB_CHECK_EQ(used, nodes_.size());
}

// Splits at the median, so that the depth is logarithmic for any mesh, and the place of each node
// known beforehand.
size_t TriangleTree::split(size_t node, int32_t first, std::span<Center> centers, size_t children) {
    Box3d whole;
    Box3d spread;
    for (const Center& c : centers) {
        whole.add(box(c.triangle));
        spread.add(c.at);
    }
    nodes_[node] = {whole, first, static_cast<int32_t>(centers.size()), centers.size() <= kLeaf};
    if (nodes_[node].leaf) {
        for (const Center& c : centers)
            order_[first++] = c.triangle;
        return children;
    }
    const Vec3d size = spread.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t half = centers.size() / 2;
    std::nth_element(centers.begin(), centers.begin() + static_cast<std::ptrdiff_t>(half),
                     centers.end(), [&](const Center& a, const Center& b) {
                         return std::pair(a.at[axis], a.triangle) <
                                std::pair(b.at[axis], b.triangle);
                     });
    nodes_[node].first = static_cast<int32_t>(children);
    const auto lower = [&] { return split(children, first, centers.first(half), children + 2); };
    const auto upper = [&](size_t free) {
        return split(children + 1, first + static_cast<int32_t>(half), centers.subspan(half), free);
    };
    if (centers.size() <= kSplitAlone) return upper(lower());
    size_t end = 0;
    tbb::parallel_invoke(lower, [&] { end = upper(children + 1 + count_nodes(half)); });
    return end;
}

std::vector<TriangleTree::NodePair> TriangleTree::parts_of_search(size_t count) const {
    std::vector<NodePair> parts, next;
    if (!nodes_.empty()) parts.push_back({});
    for (size_t before = 0; before != parts.size() && parts.size() < count;) {
        before = parts.size();
        next.clear();
        for (const NodePair& part : parts) {
            if (!overlap(part)) continue;
            if (!expand(part, &next)) next.push_back(part);
        }
        parts.swap(next);
    }
    return parts;
}

}  // namespace openfab::mesh
