// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Trees of meshes, and the nearest triangle in them by exhaustive search.

#include <cmath>

#include "runtime/nearest/tree/hierarchy.h"
#include "tests/support/mesh_surface.h"

namespace openfab::nearest::testing {

inline Vec3f to_vec(const float* v) {
    return {v[0], v[1], v[2]};
}

inline Tree tree_of(const openfab::testing::TriangleMesh& mesh) {
    std::vector<InputTriangle> input;
    for (const auto& t : mesh.triangles) {
        const auto at = [&](size_t k) { return mesh.positions[t[k]]; };
        input.push_back({{at(0), at(1), at(2)}, static_cast<int32_t>(input.size()), 0});
    }
    return build_tree(input, {});
}

struct NearestTriangle {
    uint32_t index = 0;  ///< in the tree
    Hit hit{INFINITY, 0, 0};
    Vec3f point;
};

inline NearestTriangle nearest_triangle(const Tree& tree, const Vec3f& p) {
    NearestTriangle best;
    for (uint32_t t = 0; t < tree.frames.size(); ++t) {
        const Hit hit = closest_point(tree.frames[t], tree.details[t], p);
        const TriangleDetail &a = tree.details[t], &b = tree.details[best.index];
        if (hit.distance2 > best.hit.distance2 ||
            (hit.distance2 == best.hit.distance2 &&
             !precedes(a.patch, a.triangle, b.patch, b.triangle)))
            continue;
        best.hit = hit;
        best.index = t;
    }
    const Vec3f v0 = to_vec(tree.frames[best.index].v0);
    best.point = v0 + (to_vec(tree.details[best.index].v1) - v0) * best.hit.bary1 +
                 (to_vec(tree.details[best.index].v2) - v0) * best.hit.bary2;
    return best;
}

}  // namespace openfab::nearest::testing
