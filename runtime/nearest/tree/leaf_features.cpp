// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/leaf_features.h"

#include <algorithm>
#include <cmath>

#include "base/vec.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/leaf_half_spaces.h"
#include "runtime/nearest/tree/vec_arrays.h"

namespace openfab::nearest {
namespace {

static_assert(kMaxLeafTriangles * (1 + 3 + 3) <= kMaxLeafFeatures);

size_t features_of(const LeafFeatures& leaf, const Node& node) {
    return node.count() + size_t{leaf.edges} + leaf.vertices;
}

void add_edge(const EdgeFeature& edge, const EdgeHalfSpaces& half_spaces, LeafHalfSpaces* to) {
    to->add_edge(edge, to_vec(edge.ab) * (1.0f / std::sqrt(edge.length2)), half_spaces.wing);
}

/// Adds a vertex with its most useful edges: the one that leads most into the part, which excludes
/// convex vertices as seen from there, then those in the widest gaps.
void add_vertex(const VertexFeature& vertex, const VertexHalfSpaces& half_spaces,
                const Vec3f& normal, LeafHalfSpaces* to) {
    constexpr size_t kCandidates = VertexHalfSpaces::kMaxDirections;
    constexpr float kNone = 2;  // more than any cosine
    float x[kCandidates], y[kCandidates], z[kCandidates], first[kCandidates], gap[kCandidates];
    for (size_t i = 0; i < kCandidates; ++i) {
        const Vec3f d = to_vec(half_spaces.direction[i]);
        x[i] = d.x, y[i] = d.y, z[i] = d.z;
        // Means of edges are shorter.
        const bool is_edge = dot(d, d) > 0.99f;
        first[i] = is_edge ? dot(d, normal) : kNone;
        gap[i] = is_edge ? -1 : kNone;
    }
    const float* cost = first;
    for (int k = 0; k < kHalfSpaces; ++k, cost = gap) {
        size_t best = 0;
        for (size_t i = 1; i < kCandidates; ++i)
            best = cost[i] < cost[best] ? i : best;
        if (cost[best] == kNone) break;
        const Vec3f taken = to_vec(half_spaces.direction[best]);
        to->add(taken, to_vec(vertex.v));
        for (size_t i = 0; i < kCandidates; ++i)
            gap[i] = std::max(gap[i], x[i] * taken.x + y[i] * taken.y + z[i] * taken.z);
        gap[best] = kNone;
    }
    to->next_feature();
}

/// Returns the least step with which the offsets of all its features' points fit.
float offset_step(const Tree& tree, const Node& node, const LeafFeatures& leaf) {
    float farthest2 = 0;
    const auto add = [&](const Vec3f& v) {
        const Vec3f d = v - to_vec(leaf.origin);
        farthest2 = std::max(farthest2, dot(d, d));
    };
    for (size_t i = node.first(); i < node.first() + node.count(); ++i) {
        add(to_vec(tree.frames[i].v0));
        add(to_vec(tree.details[i].v1));
        add(to_vec(tree.details[i].v2));
    }
    return std::sqrt(farthest2) * 1.001f / LeafHalfSpaces::kMaxValue;
}

void write(const Tree& tree, const Features& f, const Node& node, const LeafFeatures& leaf,
           int16_t* values) {
    LeafHalfSpaces all(leaf.origin);
    for (size_t i = node.first(); i < node.first() + node.count(); ++i)
        all.add_face(tree.frames[i], tree.details[i]);
    for (size_t i = leaf.first_edge; i < leaf.first_edge + size_t{leaf.edges}; ++i)
        add_edge(f.edges[i], f.edge_half_spaces[i], &all);
    for (size_t i = leaf.first_vertex; i < leaf.first_vertex + size_t{leaf.vertices}; ++i)
        add_vertex(f.vertices[i], f.vertex_half_spaces[i],
                   to_vec(tree.frames[f.vertices[i].owner()].n), &all);
    all.write(leaf.step, values);
}

LeafFeatures of_leaf(const Tree& tree, const Features& f, const Node& node) {
    LeafFeatures leaf;
    const size_t first = node.first(), end = first + node.count();
    leaf.first_edge = f.first_edge[first];
    leaf.first_vertex = f.first_vertex[first];
    leaf.edges = static_cast<uint16_t>(f.first_edge[end] - leaf.first_edge);
    leaf.vertices = static_cast<uint16_t>(f.first_vertex[end] - leaf.first_vertex);
    std::copy_n(tree.frames[first].v0, 3, leaf.origin);
    leaf.step = offset_step(tree, node, leaf);
    for (size_t i = leaf.first_edge; i < f.first_edge[end]; ++i)
        leaf.inv_reach = std::max(leaf.inv_reach, f.edge_half_spaces[i].inv_reach);
    for (size_t i = leaf.first_vertex; i < f.first_vertex[end]; ++i)
        leaf.inv_reach = std::max(leaf.inv_reach, f.vertex_half_spaces[i].inv_reach);
    return leaf;
}

}  // namespace

void make_leaf_features(const Features& features, Tree* tree) {
    tree->leaves.resize(tree->nodes.size());
    size_t used = 0;
    const auto each_leaf = [&](const auto& visit) {
        for (size_t i = 0; i < tree->nodes.size(); ++i) {
            const Node& node = tree->nodes[i];
            if (node.is_leaf() && node.count() != 0) visit(node, &tree->leaves[i]);
        }
    };
    each_leaf([&](const Node& node, LeafFeatures* leaf) {
        *leaf = of_leaf(*tree, features, node);
        leaf->first_half_space = static_cast<uint32_t>(used);
        used += features_of(*leaf, node);
    });
    std::vector<int16_t>& values = tree->half_spaces.values;
    values.resize(used * HalfSpaces::kValues + kHalfSpaceLanes);
    each_leaf([&](const Node& node, const LeafFeatures* leaf) {
        write(*tree, features, node, *leaf,
              values.data() + leaf->first_half_space * HalfSpaces::kValues);
    });
}

}  // namespace openfab::nearest
