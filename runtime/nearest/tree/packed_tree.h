// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A small tree that comes and goes, in one block of memory.

#include <cstddef>
#include <memory>
#include <vector>

#include "runtime/nearest/tree/hierarchy.h"

namespace openfab::nearest {

/// A tree of diced patches; its normal cones are not known.
class PackedTree {
  public:
    PackedTree() = default;
    /// Copies a tree.
    explicit PackedTree(const Tree& tree);

    /// `nodes` is null if the tree is empty.
    const TreeView& view() const { return view_; }
    size_t nodes() const { return nodes_; }
    size_t triangles() const { return triangles_; }
    size_t bytes() const { return bytes_; }

  private:
    struct Free {
        void operator()(std::byte* block) const;
    };
    template <typename T>
    const T* put(const std::vector<T>& values, std::byte** next);

    std::unique_ptr<std::byte, Free> block_;
    TreeView view_;
    size_t nodes_ = 0, triangles_ = 0, bytes_ = 0;
};

}  // namespace openfab::nearest
