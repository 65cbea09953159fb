// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounding volume hierarchy of oriented boxes over triangles, and over the bounds of patches that
// are diced on demand. The axis-aligned box of a slanted patch would stick out into the ball of a
// deep query, which would then visit hundreds of triangles for nothing.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/tree/cones.h"
#include "runtime/nearest/tree/features.h"
#include "runtime/nearest/tree/leaf_features.h"
#include "runtime/nearest/tree/triangle.h"

namespace openfab::nearest {

/// A node: its box is the set of points c with |axis_k . c - center_k| <= half_k. One cache line.
///
/// `link`:
///     bit 31       1 for a leaf
///     inner node   bits 29..30: number of children less 1
///                  bits 0..28: the first of them, which follow each other
///     leaf         bits 28..30: number of triangles, 1 to 6, or 0 if it has a tree of its own
///                  bits 0..27: first triangle, or the id of a patch or treelet (treelets.h)
struct alignas(64) Node {
    float axis[3][3];
    float center[3];
    float half[3];
    uint32_t link;

    static constexpr uint32_t kLeaf = 1u << 31;
    bool is_leaf() const { return (link & kLeaf) != 0; }
    uint32_t child() const { return link & ((1u << 29) - 1); }
    uint32_t children() const { return (link >> 29 & 3u) + 1; }
    uint32_t count() const { return link >> 28 & 7u; }
    uint32_t first() const { return link & ((1u << 28) - 1); }
};

class NodeRanges;

constexpr int32_t kMaxLeafTriangles = 6;
constexpr int32_t kMaxDicedLeafTriangles = 4;  ///< in the tree of a diced patch
constexpr uint32_t kMaxChildren = 4;
/// Limit of the number of triangles or patches: a leaf's link can name fewer than this.
constexpr int64_t kMaxItems = int64_t{1} << 28;
static_assert(2 * kMaxItems <= int64_t{1} << 29, "an inner node's link names any node");

/// Pointers into a tree for the kernel. Node 0 is the root; `nodes` is null if the tree is empty.
struct TreeView {
    const Node* nodes = nullptr;
    const TriangleFrame* frames = nullptr;
    const TriangleDetail* details = nullptr;
    const EdgeFeature* edges = nullptr;
    const VertexFeature* vertices = nullptr;
    const LeafFeatures* leaves = nullptr;  ///< [node]
    const int16_t* half_spaces = nullptr;
    const NodeCone* cones = nullptr;     ///< [node]
    const NodeRanges* ranges = nullptr;  ///< null in the tree of a patch
    float spacing = 0;                   ///< see Tree
    float longest_edge = 0;
};

/// A hierarchy with its triangles and their features.
struct Tree {
    std::vector<Node> nodes;
    std::vector<TriangleFrame> frames;    ///< in leaf order
    std::vector<TriangleDetail> details;  ///< same order
    std::vector<EdgeFeature> edges;       ///< those of a leaf are consecutive, as are its vertices
    std::vector<VertexFeature> vertices;
    std::vector<LeafFeatures> leaves;  ///< [node]
    HalfSpaces half_spaces;
    std::vector<NodeCone> cones;   ///< [node]
    float largest_coordinate = 0;  ///< largest magnitude in any vertex or box corner, mm
    float spacing = 0;             ///< typical distance between triangles, mm; 0 without any
    float longest_edge = 0;        ///< of any triangle here or in the one-ring, mm

    TreeView view() const {
        return {nodes.data(),
                frames.data(),
                details.data(),
                edges.data(),
                vertices.data(),
                leaves.data(),
                half_spaces.values.data(),
                cones.data(),
                nullptr,
                spacing,
                longest_edge};
    }
    size_t bytes() const {
        return nodes.capacity() * sizeof(Node) + frames.capacity() * sizeof(TriangleFrame) +
               details.capacity() * sizeof(TriangleDetail) +
               edges.capacity() * sizeof(EdgeFeature) +
               vertices.capacity() * sizeof(VertexFeature) +
               leaves.capacity() * sizeof(LeafFeatures) +
               half_spaces.values.capacity() * sizeof(int16_t) +
               cones.capacity() * sizeof(NodeCone) + sizeof(Tree);
    }
};

/// A triangle to build a tree from.
struct InputTriangle {
    Vec3f v[3];
    int32_t patch;
    int32_t triangle;
};

/// A patch or treelet to build a tree from.
struct InputPatch {
    Box3f bounds;
    int32_t patch;
    const Vec3f* corners = nullptr;  ///< 8, of a tighter box inside `bounds`, or null
};

/// The surroundings of a tree's triangles.
struct TreeSurroundings {
    Box3f whole;                          ///< box of the whole surface, or empty
    std::vector<InputTriangle> one_ring;  ///< other triangles that share a vertex (make_features)
    /// The triangles are a diced patch, whose tree is small, short-lived and traversed
    /// (kernel/near.h): its leaves have fewer triangles, and its cones are not computed.
    bool diced = false;
};

/// Builds a tree by the surface area heuristic over centroids; in the calling thread alone if there
/// are few triangles. Answers do not depend on the shape of the tree.
Tree build_tree(const std::vector<InputTriangle>& triangles, const std::vector<InputPatch>& patches,
                const TreeSurroundings& around = {});

}  // namespace openfab::nearest
