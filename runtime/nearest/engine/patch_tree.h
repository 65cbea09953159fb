// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The trees of a diced patch. A lattice patch of many micropolygons is cut into pieces of
// neighbours: its own tree holds their boxes, and the tree of each is built when a query comes near
// it. Few queries come near all of a patch, and boxes cost less than features, in time and memory.
// A patch of another kind has one tree at first. If that was evicted and is needed again, or if the
// surface is crowded, the working set exceeds the cache; then it is cut, too.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/lattice_tree.h"
#include "runtime/nearest/tree/packed_tree.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Maximum micropolygons of a piece of a patch that is no lattice.
constexpr size_t kPieceTriangles = 128;
/// Maximum pieces of a patch.
constexpr int32_t kMaxPieces = 32;
static_assert(2 * surface::kTileEdges * surface::kTileEdges <= kMaxPieces * kPieceTriangles,
              "a full tile has that many pieces");

/// Numbers the pieces of all patches of a surface, from `first`: leaves name them by these ids.
struct PieceIds {
    static constexpr int32_t kNone = std::numeric_limits<int32_t>::max();

    int32_t first = kNone;  ///< kNone: patches are not cut

    /// Ids from `first` on; kNone if a leaf's link could not name those of all patches.
    static PieceIds from(size_t first, size_t patches) {
        const size_t end = first + patches * kMaxPieces;
        return {end <= static_cast<size_t>(kMaxItems) ? static_cast<int32_t>(first) : kNone};
    }
    bool has(int32_t id) const { return id >= first; }
    int32_t id(int32_t patch, int32_t piece) const { return first + patch * kMaxPieces + piece; }
    int32_t patch(int32_t id) const { return (id - first) / kMaxPieces; }
    int32_t piece(int32_t id) const { return (id - first) % kMaxPieces; }
};

/// The tree of a diced patch or of a piece of it.
struct PatchTree {
    PackedTree tree;              ///< empty if the patch has no triangle
    bool lattice = false;         ///< a lattice in pieces
    std::vector<uint16_t> order;  ///< triangles, piece after piece, of others that are cut
    Box3f bounds;                 ///< of the patch, if it has an order

    const TreeView& view() const { return tree.view(); }
    size_t bytes() const {
        return sizeof(PatchTree) + tree.bytes() + order.capacity() * sizeof(uint16_t);
    }
};

/// Appends the micropolygons of a patch.
void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out);

/// Builds the tree of a patch, over its pieces if it has many triangles, `ids` has some, and it is a
/// lattice or to be `cut`.
std::shared_ptr<const PatchTree> make_patch_tree(const surface::Surface& surface, int32_t patch,
                                                 const PieceIds& ids, bool cut,
                                                 LatticeTreeBuilder* builder);
/// Builds the tree of several lattice patches (tree/patch_units.h).
std::shared_ptr<const PatchTree> make_unit_tree(const surface::Surface& surface,
                                                std::span<const int32_t> unit,
                                                LatticeTreeBuilder* builder);
/// Builds the tree of a piece of the patch `whole`.
std::shared_ptr<const PatchTree> make_piece_tree(const surface::Surface& surface, int32_t patch,
                                                 const PatchTree& whole, int32_t piece,
                                                 LatticeTreeBuilder* builder);

}  // namespace openfab::nearest
