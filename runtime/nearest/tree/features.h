// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The edges and vertices of a tree's triangles, each once: neighbours share them, so a voxel that
// is nearest to one would otherwise evaluate it for every triangle around it. Each belongs to its
// *owner*, the lowest (patch, triangle) around it; ties go to the owner (tree/triangle.h). Trees
// that do not know each other, such as those of displaced patches, each have their own features
// where they meet: these tie, and the lower owner wins as usual.
//
// Half-spaces tell that no point of a box is nearest to a feature: a point nearest to the inside of
// an edge lies beyond the edge's line for every face at it, and a point nearest to a vertex lies
// behind it for every edge at it. This prunes most edges and vertices, and all convex ones as seen
// from inside the part.

#include <cstdint>
#include <vector>

#include "runtime/nearest/tree/triangle.h"

namespace openfab::nearest {

/// An edge, from the end a that is first in lexicographic order of position. Edges without length
/// are left out.
struct EdgeFeature {
    float a[3];
    float ab[3];  ///< to the other end
    float length2, inv_length2;
    uint32_t owner_edge;  ///< bits 0..1: the owner's edge i = (v_i, v_{i+1}); bit 2: v_{i+1} is a;
                          ///< above, the owner's index in the tree

    uint32_t owner() const { return owner_edge >> 3; }
};

/// A vertex.
struct VertexFeature {
    float v[3];
    uint32_t owner_corner;  ///< bits 0..1: the owner's corner; above, its index in the tree

    uint32_t owner() const { return owner_corner >> 2; }
};

/// The half-spaces of an edge.
struct EdgeHalfSpaces {
    /// Unit normals in the planes of two faces at the edge, inwards, times the face's height over
    /// the edge divided by its longest other side; zero where there is no such face. A point that
    /// is s > 0 along one, and nearest to a point inside the edge, is nearer to that face, squared
    /// distances differing by s² or s times that side, whichever is less.
    float wing[2][3];
    float inv_reach;  ///< 1 / the shorter such side; 0 where there is no face
};

/// The half-spaces of a vertex: directions in which the surface leaves it.
struct VertexHalfSpaces {
    static constexpr int kMaxEdges = 6;
    /// Unit vectors along edges, and up to two means of those: where p - v has a large component
    /// along a mean, it has one along an edge.
    static constexpr int kMaxDirections = kMaxEdges + 2;

    float direction[kMaxDirections][3];  ///< unused ones are zero
    float inv_reach;                     ///< 1 / the shortest of those edges; 0 without any
};

/// The features of a tree in the order of their owners: those of triangle t are
/// [first[t], first[t + 1]).
struct Features {
    std::vector<EdgeFeature> edges;
    std::vector<EdgeHalfSpaces> edge_half_spaces;  ///< [edge]
    std::vector<VertexFeature> vertices;
    std::vector<VertexHalfSpaces> vertex_half_spaces;
    std::vector<uint32_t> first_edge, first_vertex;
};

/// Triangles with their details.
struct TriangleList {
    std::vector<TriangleFrame> frames;
    std::vector<TriangleDetail> details;
};

/// Finds the features that a tree's triangles own; vertices of equal position are the same.
/// `one_ring` are the triangles of other trees that share a vertex with them: their own features
/// are left to their trees, which must know these triangles in turn.
Features make_features(const std::vector<TriangleFrame>& frames,
                       const std::vector<TriangleDetail>& details,
                       const TriangleList& one_ring = {});

}  // namespace openfab::nearest
