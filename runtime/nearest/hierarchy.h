// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounding hierarchy of oriented boxes over triangles, and over the bounds of patches that are
// diced on demand. Oriented, because a slanted patch's axis-aligned box sticks out into the ball of
// a deep query, which then visits hundreds of triangles that it need not.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/cones.h"
#include "runtime/nearest/features.h"
#include "runtime/nearest/leaf_features.h"
#include "runtime/nearest/triangle.h"

namespace openfab::nearest {

/// One box: the points c with |axis_k . c - center_k| <= half_k. One cache line.
///
/// `link`:
///     bit 31       1 for a leaf
///     inner node   bits 29..30: number of children less 1
///                  bits 0..28: the first of them, which follow each other
///     leaf         bits 28..30: number of triangles, 1 to 6, or 0 for what has a tree of its own
///                  bits 0..27: first triangle, or the id of a patch or of a chunk (chunks.h)
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
/// More triangles or patches than a leaf's link can name.
constexpr int64_t kMaxItems = int64_t{1} << 28;
static_assert(2 * kMaxItems <= int64_t{1} << 29, "an inner node's link names any node");

/// What the kernel sees of a hierarchy: node 0 is the root; no nodes where there is nothing.
struct TreeView {
    const Node* nodes = nullptr;
    const TriangleFrame* frames = nullptr;
    const TriangleDetail* details = nullptr;
    const EdgeFeature* edges = nullptr;
    const VertexFeature* vertices = nullptr;
    const LeafFeatures* leaves = nullptr;  ///< of each node
    const int16_t* half_spaces = nullptr;
    const NodeCone* cones = nullptr;     ///< of each node
    const NodeRanges* ranges = nullptr;  ///< none in a patch's
    float spacing = 0;                   ///< see Tree
    float longest_edge = 0;
};

struct Tree {
    std::vector<Node> nodes;
    std::vector<TriangleFrame> frames;    ///< in leaf order
    std::vector<TriangleDetail> details;  ///< same order
    std::vector<EdgeFeature> edges;       ///< of a leaf side by side, as vertices are
    std::vector<VertexFeature> vertices;
    std::vector<LeafFeatures> leaves;  ///< of nodes
    HalfSpaces half_spaces;
    std::vector<NodeCone> cones;   ///< of nodes
    float largest_coordinate = 0;  ///< of any vertex or box corner, mm
    float spacing = 0;             ///< how far apart triangles are, about, mm; 0 without any
    float longest_edge = 0;        ///< of any triangle here or in its ring, mm

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

struct InputTriangle {
    Vec3f v[3];
    int32_t patch;
    int32_t triangle;
};

struct InputPatch {
    Box3f bounds;
    int32_t patch;
    const Vec3f* corners = nullptr;  ///< 8, of a closer box in `bounds`, where there is one
};

/// What a tree's triangles are a part of.
struct TreeSurroundings {
    Box3f whole;                      ///< a box of more than these, or empty
    std::vector<InputTriangle> ring;  ///< others that share a vertex with them (make_features)
    /// They are a diced patch: its tree is small, made for a short time, and walked through
    /// (kernel_near.inl). Its leaves have fewer triangles, its cones are not made out.
    bool diced = false;
};

/// Builds by surface area over centroids; in this thread alone where there are few triangles. The
/// shape of the tree never shows in an answer.
Tree build_tree(const std::vector<InputTriangle>& triangles, const std::vector<InputPatch>& patches,
                const TreeSurroundings& around = {});

}  // namespace openfab::nearest
