// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Lazy treelets: the whole triangles of a surface are partitioned into treelets of neighbours, and
// the tree of each is built when a query first needs it. A large mesh can be queried as soon as it
// is partitioned, and a print pays only for the treelets it comes near. A tree does not depend on
// which thread builds it, or when.
//
// In the hierarchy over a surface a treelet is a leaf, like a patch that is diced on demand; its id
// is above those of all patches.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/nearest/tree/node_ranges.h"
#include "runtime/nearest/tree/tree_store.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// The treelets of one surface.
class LazyTreelets {
  public:
    /// Partitions the surface's identity patches if there are many. The surface must outlive this.
    /// `morton` is surface::morton_order of its patches, or empty.
    explicit LazyTreelets(const surface::Surface& surface, std::span<const uint64_t> morton = {});
    ~LazyTreelets();
    LazyTreelets(const LazyTreelets&) = delete;
    LazyTreelets& operator=(const LazyTreelets&) = delete;

    /// The input of the hierarchy over the surface: triangles that are in no treelet, and the boxes
    /// of all other patches and of treelets.
    const std::vector<InputTriangle>& triangles() const { return triangles_; }
    const std::vector<InputPatch>& boxes() const { return boxes_; }
    std::vector<InputPatch>& boxes() { return boxes_; }
    /// Frees both inputs.
    void release_input();

    /// The id of the first treelet; ids below are patches.
    int32_t first_id() const { return first_id_; }
    /// Returns whether the id is a treelet's.
    bool has(int32_t id) const { return id >= first_id_; }
    /// The patches in a treelet.
    std::span<const int32_t> patches(int32_t id) const {
        const auto c = static_cast<size_t>(id - first_id_);
        return {order_.data() + first_[c], first_[c + 1] - first_[c]};
    }

    /// Returns the tree of a treelet, built on first use; it stays valid. From any thread; takes no
    /// lock once it is built.
    const TreeView* get(int32_t id) const {
        const Treelet* made =
            made_[static_cast<size_t>(id - first_id_)].load(std::memory_order_acquire);
        return made != nullptr ? &made->view : make(id);
    }

    /// The number of treelets.
    size_t count() const { return first_.size() - 1; }
    /// The number and bytes of the trees built so far.
    size_t made() const { return made_count_.load(std::memory_order_relaxed); }
    size_t bytes_made() const { return bytes_made_.load(std::memory_order_relaxed); }
    /// Estimates the bytes of the trees still to be built, erring on the high side; `vertices` is
    /// the number of vertices of the mesh.
    size_t estimated_bytes(size_t vertices) const;

  private:
    struct Treelet {
        NodeRanges ranges;
        TreeView view;
    };
    /// Consecutive items of the Morton order that stay together.
    struct Cell {
        uint32_t first, end;
    };
    /// Consecutive triangles in order_ with their box.
    struct CellBox {
        Box3f box;
        uint32_t first, end;
    };

    std::vector<uint64_t> partition(std::span<const uint64_t> morton, float large);
    std::vector<Cell> cut_cells(std::span<const uint64_t> morton) const;
    void group_cells(std::span<const uint64_t> morton, const std::vector<Cell>& cells);
    void place_boxes();
    std::span<const CellBox> cells_of(size_t treelet) const {
        return {cells_.data() + first_cell_[treelet],
                first_cell_[treelet + 1] - first_cell_[treelet]};
    }
    std::vector<InputTriangle> triangles_of(int32_t id) const;
    std::vector<InputTriangle> one_ring_of(int32_t id,
                                           const std::vector<InputTriangle>& treelet) const;
    const TreeView* make(int32_t id) const;

    const surface::Surface& surface_;
    const int32_t first_id_;
    Box3f whole_;  ///< box of all patches that queries see
    std::vector<InputTriangle> triangles_;
    std::vector<InputPatch> boxes_;
    std::vector<std::array<Vec3f, 8>> corners_;  ///< [treelet]: of its oriented box
    /// A treelet's cells are cells_[first_cell_[treelet] ..].
    std::vector<CellBox> cells_;
    std::vector<uint32_t> first_cell_{0};
    std::vector<Box3f> bounds_;       ///< [treelet]: box of its triangles
    std::vector<int32_t> order_;      ///< patches, treelet after treelet
    std::vector<uint32_t> first_{0};  ///< [treelet]: its first index in order_
    std::unique_ptr<std::atomic<const Treelet*>[]> made_;
    mutable TreeStore trees_;
    mutable std::array<std::mutex, 64> making_;  ///< treelets share them in turn
    mutable std::atomic<size_t> made_count_{0}, bytes_made_{0}, triangles_made_{0};
};

}  // namespace openfab::nearest
