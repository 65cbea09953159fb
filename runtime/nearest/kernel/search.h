// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nearest triangles of a packet of points by one traversal of the tree, each lane with its own
// limit.

#include <cstddef>
#include <cstdint>

#include "runtime/nearest/kernel/answers.h"
#include "runtime/nearest/kernel/best.h"
#include "runtime/nearest/kernel/kernel.h"
#include "runtime/nearest/kernel/packet.h"
#include "runtime/nearest/kernel/voxel_box.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// The features of one leaf met in a traversal; indices count from `first_index`.
struct FeaturesOfLeaf {
    const TreeView& tree;
    const Node& leaf;
    const LeafFeatures& features;
    uint32_t first_index;

    OPENFAB_INLINE FeaturesOfLeaf(const NodeRef& e, uint32_t first_index)
        : tree(*e.tree),
          leaf(e.tree->nodes[e.node]),
          features(e.tree->leaves[e.node]),
          first_index(first_index) {}

    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        const uint32_t first = leaf.first();
        for (uint32_t i = 0; i < leaf.count(); ++i)
            visit(tree.frames[first + i], tree.details[first + i].margin, first_index + i);
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        const uint32_t index = first_index + leaf.count();
        for (uint32_t i = 0; i < features.edges; ++i)
            visit(tree.edges[features.first_edge + i], index + i);
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        const uint32_t index = first_index + leaf.count() + features.edges;
        for (uint32_t i = 0; i < features.vertices; ++i)
            visit(tree.vertices[features.first_vertex + i].v, index + i);
    }
    /// Prefetches what those will read.
    OPENFAB_INLINE void fetch() const {
        constexpr uint32_t kTypicalEdges = 8, kLine = 64;
        for (uint32_t i = 0; i < kMaxLeafTriangles; ++i)
            __builtin_prefetch(tree.frames + leaf.first() + i);
        __builtin_prefetch(&tree.details[leaf.first()].margin);
        const auto* edges = reinterpret_cast<const char*>(tree.edges + features.first_edge);
        for (uint32_t i = 0; i < kTypicalEdges * sizeof(EdgeFeature); i += kLine)
            __builtin_prefetch(edges + i);
        __builtin_prefetch(tree.vertices + features.first_vertex);
    }
};

/// The features of all leaves met in a traversal.
struct FeaturesOfLeaves {
    const KernelScratch& scratch;

    OPENFAB_INLINE FeaturesOfLeaf leaf(size_t i) const {
        return {scratch.leaves.data[i], static_cast<uint32_t>(i) * kLeafStride};
    }
    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        for (size_t i = 0; i < scratch.leaves.size; ++i)
            leaf(i).faces(visit);
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        for (size_t i = 0; i < scratch.leaves.size; ++i)
            leaf(i).edges(visit);
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        for (size_t i = 0; i < scratch.leaves.size; ++i)
            leaf(i).vertices(visit);
    }
    FoundFeature feature(int32_t index) const { return found_at(scratch, index); }
    FeatureAnswer answer(int32_t index) const { return answer_of(feature(index)); }
};

/// A packet and the result of its traversal; indices are those of FeaturesOfLeaves.
template <typename V>
struct SearchOf {
    PointsOf<V> p;
    FeatureBest<V> best;
    V limit;  ///< distance2 with slack; negative in inactive lanes
    V slack;  ///< (r + delta)² - r², with r at least any distance found
};

template <typename V>
OPENFAB_INLINE V limit_of(V distance2, V slack) {
    return distance2 * V(kSlack) + slack;
}

/// Starts a search of the `active` lanes within start2, mm², which is finite. `delta` is that of
/// kernel_table.h, per lane.
template <typename V>
OPENFAB_INLINE void begin_search(uint32_t active, V start2, V delta, KernelScratch* scratch,
                                 SearchOf<V>* s) {
    const V r = sqrt(start2);
    s->slack = (r + r + delta) * delta * V(kSlack * kSlack) + V(kSlackMm2);
    s->best = nothing_found<V>();
    s->limit = select(V::Mask::from_bits(active), limit_of(start2, s->slack), V(-1.0f));
    scratch->leaves.size = 0;
}

template <typename V>
OPENFAB_INLINE void search_leaf(const NodeRef& entry, KernelScratch* scratch, SearchOf<V>* s) {
    const FeaturesOfLeaf leaf(entry, static_cast<uint32_t>(scratch->leaves.size) * kLeafStride);
    scratch->leaves.push(entry);
    update_nearest(leaf, s->p, &s->best);
    // The smaller of both: inactive lanes stay negative, and a radius never widens.
    s->limit = min(s->limit, limit_of(s->best.distance2, s->slack));
    scratch->counts->triangle_tests += int64_t{leaf.leaf.count()} * V::kLanes / 8;
}

/// The leaf that is being prefetched while the traversal goes on to the next.
template <typename V>
struct PrefetchedLeaf {
    NodeRef entry{nullptr, 0};
    V distance2 = V(0.0f);  ///< to its box

    OPENFAB_INLINE void flush(KernelScratch* scratch, SearchOf<V>* s) {
        if (entry.tree != nullptr && any(distance2 <= s->limit)) search_leaf(entry, scratch, s);
        entry.tree = nullptr;
    }
    OPENFAB_INLINE void prefetch(const NodeRef& next, V next_distance2, KernelScratch* scratch,
                                 SearchOf<V>* s) {
        FeaturesOfLeaf(next, 0).fetch();
        flush(scratch, s);
        entry = next;
        distance2 = next_distance2;
    }
};

/// Searches below the nodes `starts`. frontier_distance2 holds the distances of the nodes on the
/// stack, index for index.
template <typename V>
__attribute__((noinline)) void search(const NodeRef* starts, size_t count, KernelScratch* scratch,
                                      SearchOf<V>* result) {
    SearchOf<V> local = *result;
    SearchOf<V>* const s = &local;
    scratch->stack.size = 0;
    const auto push = [&](const NodeRef& e, V distance2) OPENFAB_INLINE_LAMBDA {
        const size_t index = scratch->stack.size;
        scratch->stack.push(e);
        scratch->frontier_distance2.reserve(index + 1);
        store(scratch->frontier_distance2.data[index].v, distance2);
    };
    for (size_t i = 0; i < count; ++i) {
        const V distance2 = node_distance2(starts[i].tree->nodes[starts[i].node], s->p);
        if (bits(distance2 <= s->limit) != 0) push(starts[i], distance2);
    }
    scratch->counts->node_tests += static_cast<int64_t>(count) * V::kLanes / 8;
    PrefetchedLeaf<V> pending;
    while (scratch->stack.size != 0) {
        const size_t top = --scratch->stack.size;
        const NodeRef e = scratch->stack.data[top];
        V distance2 = V::load(scratch->frontier_distance2.data[top].v);
        if (bits(distance2 <= s->limit) == 0) continue;
        const TreeView* tree = e.tree;
        const Node* node = tree->nodes + e.node;
        while (node != nullptr) {
            if (node->is_leaf() && node->count() == 0) {
                const Node* box = cached_box(scratch->patches, *node);
                if (box != nullptr && bits(node_distance2(*box, s->p) <= s->limit) == 0) break;
                tree = scratch->patches.fetch(scratch->patches.context,
                                              static_cast<int32_t>(node->first()));
                node = tree->nodes;
                continue;
            }
            if (node->is_leaf()) {
                pending.prefetch({tree, static_cast<uint32_t>(node - tree->nodes)}, distance2,
                                 scratch, s);
                break;
            }
            V of_child[kMaxChildren];
            const uint32_t near = test_children(*tree, *node, s->p, s->limit, of_child);
            scratch->counts->node_tests += node->children() * V::kLanes / 8;
            const uint32_t child = node->child();
            node = nullptr;
            if (near == 0) break;
            const uint32_t nearest = nearest_child(of_child);
            each_other_child(near, nearest, [&](uint32_t i) OPENFAB_INLINE_LAMBDA {
                push({tree, child + i}, of_child[i]);
            });
            if ((near >> nearest & 1u) != 0) {
                node = tree->nodes + child + nearest;
                distance2 = of_child[nearest];
            }
        }
    }
    pending.flush(scratch, s);
    *result = local;
}

/// Keeps the point a lane found: the points of the next packet are near it.
OPENFAB_INLINE void keep_point(const FoundFeature& feature, float bary1, float bary2,
                               WarmStart* warm) {
    const uint32_t t = triangle_of(feature);
    const TriangleFrame& frame = feature.tree->frames[t];
    const TriangleDetail& detail = feature.tree->details[t];
    for (int a = 0; a < 3; ++a) {
        const float v0 = frame.v0[a];
        warm->point[a][warm->count] =
            v0 + (bary1 * (detail.v1[a] - v0) + bary2 * (detail.v2[a] - v0));
    }
    ++warm->count;
}

/// Returns the squared distance to the nearest warm point, an upper bound of the answer's.
template <typename V>
OPENFAB_INLINE V warm_distance2(const WarmStart& warm, const PointsOf<V>& p, V start2) {
    for (int i = 0; i < warm.count; ++i) {
        const float at[3] = {warm.point[0][i], warm.point[1][i], warm.point[2][i]};
        start2 = min(start2, distance2_to(at, p));
    }
    return start2;
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
