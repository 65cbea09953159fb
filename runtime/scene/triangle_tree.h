// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A tree of boxes over a mesh's triangles, for checks at load.

#include <vector>

#include "runtime/base/vec.h"
#include "runtime/scene/mesh.h"

namespace openfab::scene {

class TriangleTree {
  public:
    /// Keeps no reference to the mesh. n log n.
    explicit TriangleTree(const Mesh& mesh);

    const Box3d& box(int32_t triangle) const { return boxes_[static_cast<size_t>(triangle)]; }

    /// Calls visit(triangle) for each triangle whose box touches `box`, until it returns false. The
    /// order depends on the mesh alone.
    template <typename Visit>
    void for_each_in(const Box3d& box, Visit visit) const {
        int32_t stack[64];
        int depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[static_cast<size_t>(stack[--depth])];
            if (!node.box.overlaps(box)) continue;
            if (node.count == 0) {
                stack[depth++] = node.first + 1;
                stack[depth++] = node.first;
                continue;
            }
            for (int32_t i = node.first; i < node.first + node.count; ++i) {
                const int32_t t = order_[static_cast<size_t>(i)];
                if (this->box(t).overlaps(box) && !visit(t)) return;
            }
        }
    }

  private:
    struct Node {
        Box3d box;
        int32_t first = 0;  ///< inner: the first of two children in a row; leaf: place in order_
        int32_t count = 0;  ///< 0: inner
    };
    void split(size_t node, int32_t first, int32_t count);

    std::vector<Box3d> boxes_;  ///< by triangle
    std::vector<int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace openfab::scene
