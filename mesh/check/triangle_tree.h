// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bounding volume hierarchy over a mesh's triangles, for checks at load.

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/vec.h"
#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// The hierarchy of one mesh.
class TriangleTree {
  public:
    /// Builds the tree in O(n log n); keeps no reference to the mesh.
    explicit TriangleTree(const Mesh& mesh);

    const Box3d& box(int32_t triangle) const { return boxes_[triangle]; }

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
            if (!node.leaf) {
                OPENFAB_CHECK_LE(depth + 2, 64);
                stack[depth++] = node.first + 1;
                stack[depth++] = node.first;
                continue;
            }
            for (int32_t i = node.first; i < node.first + node.size; ++i) {
                const int32_t t = order_[i];
                if (this->box(t).overlaps(box) && !visit(t)) return;
            }
        }
    }

    /// Calls visit(lower, higher) once for each two triangles whose boxes touch, until it returns
    /// false. The order depends on the mesh alone.
    template <typename Visit>
    void for_each_pair(Visit visit) const {
        std::vector<std::pair<int32_t, int32_t>> waiting;  // of nodes, or one node with itself
        if (!nodes_.empty()) waiting.emplace_back(0, 0);
        while (!waiting.empty()) {
            const auto [i, j] = waiting.back();
            waiting.pop_back();
            const Node& a = nodes_[i];
            const Node& b = nodes_[j];
            if (i != j && !a.box.overlaps(b.box)) continue;
            if (i == j && !a.leaf) {
                waiting.emplace_back(a.first, a.first + 1);
                waiting.emplace_back(a.first + 1, a.first + 1);
                waiting.emplace_back(a.first, a.first);
            } else if (!a.leaf && (b.leaf || a.size >= b.size)) {
                waiting.emplace_back(a.first, j);
                waiting.emplace_back(a.first + 1, j);
            } else if (!b.leaf) {
                waiting.emplace_back(i, b.first);
                waiting.emplace_back(i, b.first + 1);
            } else if (!visit_pairs(a, b, visit)) {
                return;
            }
        }
    }

  private:
    struct Node {
        Box3d box;
        int32_t first = 0;  ///< inner: the first of two consecutive children; leaf: index in order_
        int32_t size = 0;   ///< triangles in it
        bool leaf = false;
    };
    /// Visits the pairs of two leaves, or of one with itself; returns whether visit never returned
    /// false.
    template <typename Visit>
    bool visit_pairs(const Node& a, const Node& b, const Visit& visit) const {
        for (int32_t i = a.first; i < a.first + a.size; ++i) {
            const int32_t t = order_[i];
            for (int32_t j = &a == &b ? i + 1 : b.first; j < b.first + b.size; ++j) {
                const int32_t other = order_[j];
                if (box(t).overlaps(box(other)) && !visit(std::min(t, other), std::max(t, other)))
                    return false;
            }
        }
        return true;
    }
    struct Center {
        Vec3d at;
        int32_t triangle;
    };
    void split(size_t node, int32_t first, std::span<Center> centers);

    std::vector<Box3d> boxes_;  ///< by triangle
    std::vector<int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace openfab::mesh
