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
    /// Builds the tree in O(n log n), in parallel; keeps no reference to the mesh.
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

    /// Two nodes whose triangles are to be paired, or one with itself.
    struct NodePair {
        int32_t a = 0, b = 0;
    };
    /// Divides the search for pairs of triangles whose boxes touch into `count` parts or more, or
    /// into as many as there are. They depend on the mesh alone.
    std::vector<NodePair> parts_of_search(size_t count) const;

    /// Calls visit(lower, higher) once for each two triangles of a part whose boxes touch, until it
    /// returns false. The order depends on the mesh alone. The part `{}` is the whole search.
    template <typename Visit>
    void for_each_pair(const NodePair& part, Visit visit) const {
        std::vector<NodePair> waiting;
        if (!nodes_.empty()) waiting.push_back(part);
        while (!waiting.empty()) {
            const NodePair pair = waiting.back();
            waiting.pop_back();
            if (!overlap(pair) || expand(pair, &waiting)) continue;
            if (!visit_pairs(nodes_[pair.a], nodes_[pair.b], visit)) return;
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
    /// Makes a node and those below it, which begin at `children`; returns where they end.
    size_t split(size_t node, int32_t first, std::span<Center> centers, size_t children);
    bool overlap(const NodePair& pair) const {
        return pair.a == pair.b || nodes_[pair.a].box.overlaps(nodes_[pair.b].box);
    }
    /// Adds the pairs that a pair consists of; false if it is of leaves.
    bool expand(const NodePair& pair, std::vector<NodePair>* out) const {
        const auto [i, j] = pair;
        const Node& a = nodes_[i];
        const Node& b = nodes_[j];
        if (i == j && !a.leaf) {
            out->push_back({a.first, a.first + 1});
            out->push_back({a.first + 1, a.first + 1});
            out->push_back({a.first, a.first});
        } else if (!a.leaf && (b.leaf || a.size >= b.size)) {
            out->push_back({a.first, j});
            out->push_back({a.first + 1, j});
        } else if (!b.leaf) {
            out->push_back({i, b.first});
            out->push_back({i, b.first + 1});
        } else {
            return false;
        }
        return true;
    }

    std::vector<Box3d> boxes_;  ///< by triangle
    std::vector<int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace openfab::mesh
