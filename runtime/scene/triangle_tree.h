// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A tree of boxes over a mesh's triangles, for checks at load.

#include <algorithm>
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
        walk(box, 0, visit);
    }

    /// Calls visit(lower, higher) once for each two triangles whose boxes touch, until it returns
    /// false. The order depends on the mesh alone.
    template <typename Visit>
    void for_each_pair(Visit visit) const {
        bool more = true;
        for (size_t i = 0; i + 1 < order_.size() && more; ++i) {
            const int32_t t = order_[i];
            walk(box(t), static_cast<int32_t>(i + 1), [&](int32_t other) {
                more = visit(std::min(t, other), std::max(t, other));
                return more;
            });
        }
    }

  private:
    struct Node {
        Box3d box;
        int32_t first = 0;  ///< inner: the first of two children in a row; leaf: place in order_
        int32_t count = 0;  ///< 0: inner
        int32_t end = 0;    ///< the place in order_ behind all that is in it
    };
    /// Of the triangles that stand in order_ from `from` on.
    template <typename Visit>
    void walk(const Box3d& box, int32_t from, const Visit& visit) const {
        int32_t stack[64];
        int depth = 0;
        if (!nodes_.empty()) stack[depth++] = 0;
        while (depth > 0) {
            const Node& node = nodes_[static_cast<size_t>(stack[--depth])];
            if (node.end <= from || !node.box.overlaps(box)) continue;
            if (node.count == 0) {
                stack[depth++] = node.first + 1;
                stack[depth++] = node.first;
                continue;
            }
            for (int32_t i = std::max(node.first, from); i < node.end; ++i) {
                const int32_t t = order_[static_cast<size_t>(i)];
                if (this->box(t).overlaps(box) && !visit(t)) return;
            }
        }
    }
    void split(size_t node, int32_t first, int32_t count);

    std::vector<Box3d> boxes_;  ///< by triangle
    std::vector<int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace openfab::scene
