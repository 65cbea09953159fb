// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edges and vertices of a tree's triangles, each once: neighbours share them, so a voxel that
// is nearest to one would otherwise evaluate it for every triangle around it. Each belongs to its
// *owner*, the lowest (patch, triangle) around it, which wins its ties (nearest/triangle.h). Where
// trees meet that do not know each other, as those of displaced patches, each side has its own:
// then two features tie, and the lower owner wins as between any others.
//
// Their sides tell that no point of a box is nearest to them: the part of space that is nearest to
// the inside of an edge lies beyond that edge's line for every face at it, and the part that is
// nearest to a vertex lies behind it for every edge at it. Most edges and vertices drop out by
// that, all convex ones as seen from within the part.

#include <cstdint>
#include <vector>

#include "runtime/nearest/triangle.h"

namespace openfab::nearest {

/// One edge, from the end a that comes first in lexicographic order of position. Edges without
/// length are left out.
struct EdgeFeature {
    float a[3];
    float ab[3];  ///< to the other end
    float length2, inv_length2;
    uint32_t owner_edge;  ///< bits 0..1: the owner's edge i = (v_i, v_{i+1}); bit 2: v_{i+1} is a;
                          ///< above, the owner's place in the tree

    uint32_t owner() const { return owner_edge >> 3; }
};

struct VertexFeature {
    float v[3];
    uint32_t owner_corner;  ///< bits 0..1: the owner's corner; above, its place in the tree

    uint32_t owner() const { return owner_corner >> 2; }
};

/// How the surface lies at an edge.
struct EdgeSides {
    /// Unit normals in the planes of two faces at the edge, inwards, times the face's height over
    /// the edge divided by its longest other side; zero where there is no such face. A point that
    /// is s > 0 along one, and nearest to a point inside the edge, is nearer to that face, squared
    /// distances differing by s² or s times that side, whichever is less.
    float wing[2][3];
    float inv_reach;  ///< 1 / the shorter such side; 0 where there is no face
};

/// Directions in which the surface leaves a vertex.
struct VertexSides {
    static constexpr int kMaxEdges = 6;
    /// Unit vectors along edges, and up to two means of those: where p - v has a large component
    /// along a mean, it has one along an edge.
    static constexpr int kMaxDirections = kMaxEdges + 2;

    float direction[kMaxDirections][3];  ///< the rest is zero
    float inv_reach;                     ///< 1 / the shortest of those edges; 0 without any
};

/// In the order of their owners: those of triangle t are [first[t], first[t + 1]).
struct Features {
    std::vector<EdgeFeature> edges;
    std::vector<EdgeSides> edge_sides;  ///< of each edge
    std::vector<VertexFeature> vertices;
    std::vector<VertexSides> vertex_sides;
    std::vector<uint32_t> first_edge, first_vertex;
};

struct TriangleList {
    std::vector<TriangleFrame> frames;
    std::vector<TriangleDetail> details;
};

/// The features that a tree's triangles own, whose ends are the same where their positions are
/// equal. `ring` are triangles of other trees that share a vertex with them: what those own is left
/// to their trees, which must know these.
Features make_features(const std::vector<TriangleFrame>& frames,
                       const std::vector<TriangleDetail>& details, const TriangleList& ring = {});

}  // namespace openfab::nearest
