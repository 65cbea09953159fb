// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles, features and half-spaces of the leaves of one diced lattice patch.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/lattice_cells.h"
#include "runtime/nearest/tree/lattice_tree.h"
#include "runtime/nearest/tree/leaf_sides.h"
#include "runtime/nearest/tree/unit_features.h"

namespace openfab::nearest {

/// Appends the leaves of patches to a tree. Memory is reused from patch to patch.
class LatticeLeaves {
  public:
    /// Begins a patch; returns false if it does not have its lattice's triangles.
    bool begin(const LatticePatch& patch);
    /// Makes the triangles of a block, and of the cells around it, ready for `append`.
    void prepare(const CellBlock& block);
    /// Takes triangles and features of the patch from a unit, where they begin at `first`.
    void take_from(const UnitFeatures& unit, size_t first) {
        unit_ = &unit;
        first_in_unit_ = first;
    }
    const LatticeCells& cells() const { return cells_; }
    const Vec3f* positions() const { return positions_; }

    /// The sum of area vectors and of areas of triangles.
    struct Area {
        Vec3f vector;
        float size = 0;
        void add(const Area& other) {
            vector = vector + other.vector;
            size += other.size;
        }
    };
    /// Appends what a leaf with the triangles of this block has, except its node. Returns the
    /// triangles' area.
    Area append(const CellBlock& block, LeafFeatures* leaf, Tree* tree);

  private:
    /// The edges that leave a lattice point: H, V, X of lattice_cells.h with its cell.
    struct PointEdges {
        std::array<Vec3f, 3> along;   ///< unit vectors, from the point that the name has first
        std::array<float, 3> length;  ///< mm; 0 where there is no such edge
    };
    /// A side of a triangle and the edge it lies on.
    struct Side {
        int32_t point;  ///< whose edge it is
        int edge;       ///< 0 to 2: H, V, X
    };
    /// A triangle at an edge: its number in the mesh, -1 if absent, and which of its sides.
    struct Face {
        int32_t triangle;
        int side;
    };
    struct Wing {
        float rho = 0, reach = 0;
    };

    void measure_edges(const CellBlock& around);
    Area add_triangle(int32_t triangle, Tree* tree) const;
    void add_own_features(const CellBlock& block, LeafFeatures* leaf, Tree* tree);
    template <typename Visit>
    void each_triangle(const CellBlock& block, const Visit& visit) const;
    void add_edge(int32_t owner, const Side& edge, const Face& own, const Face& other,
                  LeafFeatures* leaf, Tree* tree);
    void add_vertex(int32_t owner, int corner, int32_t a, int32_t b, LeafFeatures* leaf,
                    Tree* tree);
    Wing wing(const Face& face) const;
    void add_features_of_upper(int32_t a, int32_t b, int32_t owner, LeafFeatures* leaf, Tree* tree);
    void add_features_of_lower(int32_t a, int32_t b, int32_t owner, LeafFeatures* leaf, Tree* tree);
    void write_half_spaces(size_t first, size_t count, LeafFeatures* leaf, Tree* tree);

    LatticeCells cells_;
    LatticePatch patch_{};
    const Vec3f* positions_ = nullptr;
    std::vector<TriangleFrame> frames_;  ///< [triangle of the mesh]
    std::vector<TriangleDetail> details_;
    std::vector<std::array<float, 3>> side_lengths_;  ///< [triangle of the mesh]
    std::vector<PointEdges> edges_;                   ///< [vertex of the mesh]
    const UnitFeatures* unit_ = nullptr;
    size_t first_in_unit_ = 0;
    LeafSides sides_;  ///< of the leaf that is being made
};

}  // namespace openfab::nearest
