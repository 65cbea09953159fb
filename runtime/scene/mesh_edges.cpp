// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/mesh_edges.h"

#include <algorithm>

namespace openfab::scene {

std::vector<Edge> sorted_edges(const Mesh& mesh) {
    std::vector<Edge> edges;
    edges.reserve(mesh.triangles.size() * 3);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (size_t i = 0; i < 3; ++i) {
            const int32_t from = mesh.triangles[t][i];
            const int32_t to = mesh.triangles[t][(i + 1) % 3];
            edges.push_back(
                {std::min(from, to), std::max(from, to), static_cast<int32_t>(t), from < to});
        }
    }
    std::sort(edges.begin(), edges.end(),
              [](const Edge& x, const Edge& y) { return x.key() < y.key(); });
    return edges;
}

}  // namespace openfab::scene
