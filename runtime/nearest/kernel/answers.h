// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Answers of features.

#include <cstdint>

#include "runtime/nearest/kernel/kernel.h"
#include "simd/target.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// Farther than any feature, but less than the infinity of an excluded one.
constexpr float kNoFeature = 0x1.fffffep127f;

OPENFAB_INLINE FeatureAnswer face_answer(const TriangleDetail& d) {
    return {0, d.inv_height1, 0, d.inv_height2, d.patch, d.triangle, 0};
}

/// [low bits of EdgeFeature::owner_edge]: the point at parameter tau along edge i of its owner, or
/// in reverse.
constexpr FeatureAnswer kAlongEdge[8] = {
    {0, 1, 0, 0, 0, 0, 1},  {1, -1, 0, 1, 0, 0, 2}, {0, 0, 1, -1, 0, 0, 3}, {},
    {1, -1, 0, 0, 0, 0, 1}, {0, 1, 1, -1, 0, 0, 2}, {0, 0, 0, 1, 0, 0, 3},  {},
};

OPENFAB_INLINE FeatureAnswer edge_answer(const EdgeFeature& e, const TriangleDetail& owner) {
    FeatureAnswer a = kAlongEdge[e.owner_edge & 7u];
    a.patch = owner.patch;
    a.triangle = owner.triangle;
    return a;
}

OPENFAB_INLINE FeatureAnswer vertex_answer(const VertexFeature& v, const TriangleDetail& owner) {
    const auto c = static_cast<int32_t>(v.owner_corner & 3u);
    return {c == 1 ? 1.0f : 0.0f, 0, c == 2 ? 1.0f : 0.0f, 0, owner.patch, owner.triangle, 4 + c};
}

/// Returns whether `a` wins a tie with `b`: by (patch, triangle, order).
OPENFAB_INLINE bool comes_first(const FeatureAnswer& a, const FeatureAnswer& b) {
    if (a.patch != b.patch) return a.patch < b.patch;
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.order < b.order;
}

/// A feature by its index in its tree.
struct FoundFeature {
    enum Kind { kFace, kEdge, kVertex };
    const TreeView* tree;
    uint32_t index;
    Kind kind;
};

/// Indices per leaf, in the order faces, edges, vertices; no leaf has more features.
constexpr int32_t kLeafStride = 64;
static_assert(kLeafStride >= kMaxLeafTriangles * (1 + 3 + 3));

OPENFAB_INLINE FoundFeature found_at(const KernelScratch& scratch, int32_t index) {
    const NodeRef& e = scratch.leaves.data[index / kLeafStride];
    const Node& leaf = e.tree->nodes[e.node];
    const LeafFeatures& features = e.tree->leaves[e.node];
    auto i = static_cast<uint32_t>(index % kLeafStride);
    if (i < leaf.count()) return {e.tree, leaf.first() + i, FoundFeature::kFace};
    i -= leaf.count();
    if (i < features.edges) return {e.tree, features.first_edge + i, FoundFeature::kEdge};
    i -= features.edges;
    return {e.tree, features.first_vertex + i, FoundFeature::kVertex};
}

/// Returns the index in the tree of the triangle that owns the feature.
OPENFAB_INLINE uint32_t triangle_of(const FoundFeature& f) {
    if (f.kind == FoundFeature::kEdge) return f.tree->edges[f.index].owner();
    if (f.kind == FoundFeature::kVertex) return f.tree->vertices[f.index].owner();
    return f.index;
}

inline FeatureAnswer answer_of(const FoundFeature& f) {
    const TriangleDetail& owner = f.tree->details[triangle_of(f)];
    if (f.kind == FoundFeature::kEdge) return edge_answer(f.tree->edges[f.index], owner);
    if (f.kind == FoundFeature::kVertex) return vertex_answer(f.tree->vertices[f.index], owner);
    return face_answer(owner);
}

OPENFAB_INLINE void write_voxel(int v, const FeatureAnswer& a, float distance2, float bary1,
                                float bary2, BlockAnswer* answer) {
    answer->distance2[v] = distance2;
    answer->item[v] = a.patch;
    answer->in_patch.triangle[v] = a.triangle;
    answer->in_patch.bary1[v] = bary1;
    answer->in_patch.bary2[v] = bary2;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
