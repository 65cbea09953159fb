// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The trees of a diced patch. At first it has one. If that was evicted and is needed again, or if
// the surface is crowded, the working set exceeds the cache; then a patch of many micropolygons is cut into pieces of
// neighbours: its own tree holds their boxes, and the tree of each is built when a query comes near
// it. Few queries come near all of a patch, and boxes cost less than features, in time and memory;
// but where all trees stay cached, queries of whole ones are up to a quarter faster.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/surface/lattice.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Maximum micropolygons of a piece.
constexpr size_t kPieceTriangles = 128;
/// Maximum pieces of a patch.
constexpr int32_t kMaxPieces = 16;
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
    Tree tree;
    TreeView view;                ///< `nodes` is null if the patch has no triangle
    std::vector<uint16_t> order;  ///< triangles, piece after piece; empty if the patch is not cut
    Box3f bounds;                 ///< of the patch, if it is cut

    size_t bytes() const { return tree.bytes() + order.capacity() * sizeof(uint16_t); }
};

/// Appends the micropolygons of a patch.
void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out);

/// Builds the tree of a patch, over its pieces if it has many triangles and `ids` has some.
std::shared_ptr<const PatchTree> make_patch_tree(const surface::MicroMesh& mesh, int32_t patch,
                                                 const PieceIds& ids);
/// Builds the tree of a piece of the patch `whole`.
std::shared_ptr<const PatchTree> make_piece_tree(const surface::MicroMesh& mesh, int32_t patch,
                                                 const PatchTree& whole, int32_t piece);

}  // namespace openfab::nearest
