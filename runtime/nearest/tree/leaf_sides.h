// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the half-spaces of a leaf are written from, for trees of diced patches.

#include <array>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/tree/leaf_features.h"

namespace openfab::nearest {

/// Of the edges and vertices of the leaf that is being made, in its order.
struct LeafSides {
    struct Edge {
        Vec3f along;  ///< unit vector, as EdgeFeature::ab
        float wing[2][3];
    };
    struct Vertex {
        int count = 0;
        std::array<Vec3f, kHalfSpaces> direction;  ///< unit vectors along edges
    };
    std::vector<Edge> edges;
    std::vector<Vertex> vertices;

    void clear() {
        edges.clear();
        vertices.clear();
    }
};

}  // namespace openfab::nearest
