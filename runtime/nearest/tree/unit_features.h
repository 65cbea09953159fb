// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The features of several small patches that make one tree. Where patches meet they share edges and
// vertices, which are found by position: half of a small patch is border.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/lattice_tree.h"
#include "runtime/nearest/tree/leaf_sides.h"

namespace openfab::nearest {

/// Memory is reused from unit to unit.
class UnitFeatures {
  public:
    /// Finds the features of a unit's patches.
    void find(std::span<const LatticePatch* const> patches);
    /// The number of the first triangle of a patch, by its place in the unit. Triangles are
    /// numbered in the order in which they win ties.
    size_t first_triangle(size_t patch) const { return first_[patch]; }
    const TriangleFrame& frame(size_t triangle) const { return frames_[triangle]; }
    const TriangleDetail& detail(size_t triangle) const { return details_[triangle]; }
    /// Append the edges or the vertices that a triangle owns; `owner` is its index in the tree.
    void append_edges(size_t triangle, uint32_t owner, LeafFeatures* leaf, LeafSides* sides,
                      Tree* tree) const;
    void append_vertices(size_t triangle, uint32_t owner, LeafFeatures* leaf, LeafSides* sides,
                         Tree* tree) const;

  private:
    static constexpr uint32_t kNone = UINT32_MAX;
    static constexpr size_t kMaxSpokes = 8;

    struct Edge {
        uint32_t from, to;  ///< vertices
        uint32_t face[2];   ///< 3 * triangle + side; the owner's first, kNone without a second
        Vec3f along;        ///< unit vector
        float length;       ///< mm
    };
    struct Vertex {
        Vec3f at;
        uint32_t owner;  ///< 3 * triangle + corner
        uint32_t spokes;
        std::array<uint32_t, kMaxSpokes> spoke;  ///< edges
    };
    struct Wing {
        float rho = 0, reach = 0;
    };

    void add_patch(const LatticePatch& patch);
    uint32_t vertex_at(const Vec3f& position);
    uint32_t edge_between(uint32_t a, uint32_t b, uint32_t face);
    Wing wing(uint32_t face) const;
    void append_edge(const Edge& edge, uint32_t owner, LeafFeatures* leaf, LeafSides* sides,
                     Tree* tree) const;
    void append_vertex(uint32_t number, uint32_t owner, LeafFeatures* leaf, LeafSides* sides,
                       Tree* tree) const;
    Vec3f corner(size_t triangle, size_t k) const { return vertices_[corners_[triangle][k]].at; }

    std::vector<size_t> first_;    ///< [place of the patch]
    std::vector<uint32_t> by_id_;  ///< places of patches, by number of the patch
    std::vector<TriangleFrame> frames_;
    std::vector<TriangleDetail> details_;
    std::vector<std::array<uint32_t, 3>> corners_, sides_;  ///< [triangle]: vertices, edges
    std::vector<Edge> edges_;
    std::vector<Vertex> vertices_;
    std::vector<uint32_t> vertex_slots_, edge_slots_;
    std::vector<uint32_t> numbers_;  ///< [vertex of the patch's mesh]
};

}  // namespace openfab::nearest
