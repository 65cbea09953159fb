// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The tree of diced lattice patches. A lattice says by itself what a tree over it is: nodes are
// rectangles of cells, halved both ways, and neighbours are found by index. Nothing is sorted or
// hashed. Several patches of neighbours make one tree, where each has few triangles.

#include <cstdint>
#include <memory>
#include <span>

#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

class LatticeLeaves;
class UnitFeatures;

/// A patch of kind kLattice, diced.
struct LatticePatch {
    const surface::MicroMesh* mesh;
    const surface::Patch* patch;
    int32_t id;
};

/// Builds trees of lattice patches; keeps its memory from one to the next. One per thread.
class LatticeTreeBuilder {
  public:
    LatticeTreeBuilder();
    ~LatticeTreeBuilder();

    /// Builds the tree of patches, neighbours of which should follow each other. The cones are left empty: they are not
    /// known. Returns null if a patch does not have its lattice's triangles, as after a stop. The
    /// tree is valid until the next call.
    const Tree* build(std::span<const LatticePatch> patches);
    /// Builds a tree of the boxes of a patch's pieces, kPieceColumns x kPieceRows cells each or
    /// what the patch has of them: its leaves name piece k by id first_id + k.
    const Tree* build_pieces(const LatticePatch& patch, int32_t first_id);
    /// Builds the tree of a piece; features on its border belong to the piece of their owner.
    const Tree* build_piece(const LatticePatch& patch, int32_t piece);

    static constexpr int32_t kPieceColumns = 8, kPieceRows = 4;
    /// Patches of more triangles are worth cutting.
    static constexpr size_t kWholeTriangles = 16 * kPieceColumns * kPieceRows;

  private:
    Tree tree_;
    std::unique_ptr<UnitFeatures> unit_;
    std::unique_ptr<LatticeLeaves> leaves_;
};

}  // namespace openfab::nearest
