// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The whole triangles of a surface in chunks of neighbours, each of which gets a tree of its own
// when a query first needs it. A large mesh is ready to be asked once its chunks are cut, and a
// print pays for those that it comes near. Which thread makes a tree, and when, never shows in it.
//
// In the hierarchy over a surface a chunk is a leaf like a patch that is diced on demand: its id is
// above those of all patches.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "runtime/nearest/hierarchy.h"
#include "runtime/nearest/node_ranges.h"
#include "runtime/nearest/tree_store.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

class Chunks {
  public:
    /// Chunks of the surface's identity patches, where it has many. The surface must outlive them.
    /// `along` is surface::along_curve of its patches, or empty.
    explicit Chunks(const surface::Surface& surface, std::span<const uint64_t> along = {});
    ~Chunks();
    Chunks(const Chunks&) = delete;
    Chunks& operator=(const Chunks&) = delete;

    /// What the hierarchy over the surface is built from: triangles that are in no chunk, and
    /// chunks, then all other patches.
    const std::vector<InputTriangle>& triangles() const { return triangles_; }
    const std::vector<InputPatch>& boxes() const { return boxes_; }
    /// Frees both.
    void forget_input();

    int32_t first_id() const { return first_id_; }
    /// Whether the id is a chunk's; else it is a patch's.
    bool has(int32_t id) const { return id >= first_id_; }
    std::span<const int32_t> patches(int32_t id) const {
        const auto c = static_cast<size_t>(id - first_id_);
        return {order_.data() + first_[c], first_[c + 1] - first_[c]};
    }

    /// Any thread; the tree stays where it is. No lock once it is made.
    const TreeView* get(int32_t id) const {
        const Made* made =
            made_[static_cast<size_t>(id - first_id_)].load(std::memory_order_acquire);
        return made != nullptr ? &made->view : make(id);
    }

    size_t count() const { return first_.size() - 1; }
    /// Trees that have been made, and what they hold.
    size_t made() const { return made_count_.load(std::memory_order_relaxed); }
    size_t bytes_made() const { return bytes_made_.load(std::memory_order_relaxed); }
    /// About what the others will hold, rather more, in a mesh of so many vertices.
    size_t bytes_to_come(size_t vertices) const;

  private:
    struct Made {
        NodeRanges ranges;
        TreeView view;
    };
    /// Consecutive places on the curve that stay together.
    struct Cell {
        uint32_t first, end;
    };
    /// Triangles of a chunk that follow each other in order_.
    struct CellBox {
        Box3f box;
        uint32_t first, end;
    };

    std::vector<uint64_t> share_out(std::span<const uint64_t> along, float large);
    std::vector<Cell> cut_cells(std::span<const uint64_t> along) const;
    void group_cells(std::span<const uint64_t> along, const std::vector<Cell>& cells);
    void place_boxes();
    std::span<const CellBox> cells_of(size_t chunk) const {
        return {cells_.data() + first_cell_[chunk], first_cell_[chunk + 1] - first_cell_[chunk]};
    }
    std::vector<InputTriangle> triangles_of(int32_t id) const;
    std::vector<InputTriangle> ring_around(int32_t id,
                                           const std::vector<InputTriangle>& chunk) const;
    const TreeView* make(int32_t id) const;

    const surface::Surface& surface_;
    const int32_t first_id_;
    Box3f whole_;  ///< of all patches that queries see
    std::vector<InputTriangle> triangles_;
    std::vector<InputPatch> boxes_;
    std::vector<std::array<Vec3f, 8>> corners_;  ///< of boxes_
    /// cells_[first_cell_[chunk] ..] are a chunk's.
    std::vector<CellBox> cells_;
    std::vector<uint32_t> first_cell_{0};
    std::vector<Box3f> bounds_;       ///< [chunk]: of its triangles
    std::vector<int32_t> order_;      ///< patches, chunk after chunk
    std::vector<uint32_t> first_{0};  ///< [chunk]: where it begins in order_
    std::unique_ptr<std::atomic<const Made*>[]> made_;
    mutable TreeStore trees_;
    mutable std::array<std::mutex, 64> making_;  ///< chunk by chunk in turn
    mutable std::atomic<size_t> made_count_{0}, bytes_made_{0}, triangles_made_{0};
};

}  // namespace openfab::nearest
