// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The base mesh as input of dicing: classes of triangles, edge factors, shared edges and vertices,
// and which triangle evaluates a shared micro-vertex.
//
// A *side* is 3 * triangle + e, a *corner* 3 * triangle + c. Vertices are welded by position and
// numbered in order of position, so that comparing two numbers tells the lower end of an edge. A
// triangle with two equal corners has no surface and is left out everywhere, which keeps a closed
// mesh closed.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"

namespace openfab::surface {

enum class TriangleClass : uint8_t { kDropped, kIdentity, kDisplaced };

/// Tangent frame of a base triangle: the geometric normal and the derivatives of position by uv.
struct TangentFrame {
    Vec3f ng, dpdu, dpdv;
};

class BaseMesh {
  public:
    explicit BaseMesh(const part::Part& part);

    /// Computes the edge factors of all triangles, in parallel.
    void set_factors(double micro_edge_mm);
    /// Returns what they were computed for.
    double micro_edge_mm() const { return micro_edge_mm_; }
    /// Pairs sides and groups corners. `classes` must be final. Needed only if something is
    /// displaced.
    void connect();

    int32_t triangle_count() const { return static_cast<int32_t>(mesh_.triangles.size()); }
    const Vec3d& position(int32_t corner) const {
        return mesh_.positions[static_cast<size_t>(
            mesh_.triangles[static_cast<size_t>(corner / 3)][static_cast<size_t>(corner % 3)])];
    }
    /// Gets the corners rounded as in micropolygons; false if two of them, distinct in double,
    /// round to the same position.
    bool rounded_corners(int32_t triangle, std::array<Vec3f, 3>* out) const;
    Vec3f normal(int32_t corner, const Vec3f& ng) const {
        return mesh_.corner_normals.empty() ? ng : mesh_.corner_normals[corner];
    }
    TangentFrame frame(int32_t triangle) const;
    /// Returns N, the factor of the finest side.
    int32_t lattice_factor(int32_t triangle) const;
    /// Returns the corner at the lower (upper) end of a side. Valid after connect(), like all
    /// below.
    int32_t lower_corner(int32_t side) const { return forward(side) ? side : next_corner(side); }
    int32_t upper_corner(int32_t side) const { return forward(side) ? next_corner(side) : side; }
    bool forward(int32_t side) const {
        return vertex[side] < vertex[static_cast<size_t>(next_corner(side))];
    }
    static int32_t next_corner(int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

    const part::PartMesh& mesh() const { return mesh_; }

    std::vector<TriangleClass> classes;
    std::vector<int32_t> factor;   ///< [side]
    std::vector<int32_t> vertex;   ///< [corner] welded vertex, in order of position
    std::vector<int32_t> partner;  ///< [side] the opposite side along the edge, -1 if open
    std::vector<uint8_t> divided;  ///< [side] some triangle on the edge is displaced
    /// [corner] lowest corner of a displaced triangle at the vertex with the same inputs to the
    /// surface stage; its triangle evaluates the corner. Only for displaced triangles.
    std::vector<int32_t> corner_class;
    /// [side] the triangle that evaluates the points between the side's ends.
    std::vector<int32_t> side_evaluator;
    /// Corners at each welded vertex, in order of corner number: vertex_corners[vertex_first[v] …
    /// vertex_first[v + 1]).
    std::vector<int32_t> vertex_first, vertex_corners;

  private:
    int compare_inputs(int32_t corner_a, int32_t corner_b) const;
    void weld();
    void group_corners();
    void pair_sides();

    const part::PartMesh& mesh_;
    double micro_edge_mm_ = 0;
};

}  // namespace openfab::surface
