// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/mesh_edges.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "base/large_pages.h"

namespace openfab::mesh {

// Counting sort by the lower end, which few edges share; sorting all edges at once takes ten times
// as long.
std::vector<Edge> sorted_edges(const Mesh& mesh) {
    const size_t vertices = mesh.positions.size();
    std::vector<uint32_t> end(vertices + 1, 0);  // of the edges from each vertex, once inserted
    const auto lower = [](const std::array<int32_t, 3>& t, size_t i) {
        return static_cast<size_t>(std::min(t[i], t[(i + 1) % 3]));
    };
    for (const auto& t : mesh.triangles) {
        for (size_t i = 0; i < 3; ++i)
            ++end[lower(t, i) + 1];
    }
    for (size_t v = 0; v < vertices; ++v)
        end[v + 1] += end[v];
    std::vector<Edge> edges = large_vector<Edge>(mesh.triangles.size() * 3);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (size_t i = 0; i < 3; ++i) {
            const int32_t from = mesh.triangles[t][i];
            const int32_t to = mesh.triangles[t][(i + 1) % 3];
            edges[end[lower(mesh.triangles[t], i)]++] = {std::min(from, to), std::max(from, to),
                                                         static_cast<int32_t>(t), from < to};
        }
    }
    tbb::parallel_for(tbb::blocked_range<size_t>(0, vertices, 4096), [&](const auto& range) {
        for (size_t v = range.begin(); v < range.end(); ++v) {
            const auto first = edges.begin() + (v == 0 ? 0 : end[v - 1]);
            std::sort(first, edges.begin() + end[v],
                      [](const Edge& x, const Edge& y) { return x.key() < y.key(); });
        }
    });
    return edges;
}

}  // namespace openfab::mesh
