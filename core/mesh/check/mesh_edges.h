// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Edges of a mesh and the triangles that use them.

#include <cstdint>
#include <tuple>
#include <vector>

#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// One use of an edge by a triangle.
struct Edge {
    int32_t a = 0, b = 0;  ///< a < b
    int32_t triangle = 0;
    bool forward = false;  ///< the triangle runs from a to b
    auto key() const { return std::tie(a, b, triangle); }
};

/// Returns the three edges of each triangle, sorted by ends, then by triangle.
std::vector<Edge> sorted_edges(const Mesh& mesh);

/// Calls visit(first, last) for the range of uses of each undirected edge.
template <typename Visit>
void for_each_edge(const std::vector<Edge>& edges, Visit visit) {
    for (size_t i = 0; i < edges.size();) {
        size_t end = i + 1;
        while (end < edges.size() && edges[end].a == edges[i].a && edges[end].b == edges[i].b)
            ++end;
        visit(&edges[i], &edges[0] + end);
        i = end;
    }
}

}  // namespace openfab::mesh
