// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The nearest triangles of a packet of points by one walk down the hierarchy, each lane with its
// own limit. Part of kernel.inl.

/// The features of one leaf of a walk; places count from `first_place`.
struct FeaturesOfLeaf {
    const TreeView& tree;
    const Node& leaf;
    const LeafFeatures& features;
    uint32_t first_place;

    OPENFAB_INLINE FeaturesOfLeaf(const Entry& e, uint32_t first_place)
        : tree(*e.tree),
          leaf(e.tree->nodes[e.node]),
          features(e.tree->leaves[e.node]),
          first_place(first_place) {}

    template <typename Visit>
    OPENFAB_INLINE void faces(const Visit& visit) const {
        const uint32_t first = leaf.first();
        for (uint32_t i = 0; i < leaf.count(); ++i)
            visit(tree.frames[first + i], tree.details[first + i].margin, first_place + i);
    }
    template <typename Visit>
    OPENFAB_INLINE void edges(const Visit& visit) const {
        const uint32_t place = first_place + leaf.count();
        for (uint32_t i = 0; i < features.edges; ++i)
            visit(tree.edges[features.first_edge + i], place + i);
    }
    template <typename Visit>
    OPENFAB_INLINE void vertices(const Visit& visit) const {
        const uint32_t place = first_place + leaf.count() + features.edges;
        for (uint32_t i = 0; i < features.vertices; ++i)
            visit(tree.vertices[features.first_vertex + i].v, place + i);
    }
    /// Gets what those will read on its way.
    OPENFAB_INLINE void fetch() const {
        constexpr uint32_t kMostlyEdges = 8, kLine = 64;
        for (uint32_t i = 0; i < kMaxLeafTriangles; ++i)
            __builtin_prefetch(tree.frames + leaf.first() + i);
        __builtin_prefetch(&tree.details[leaf.first()].margin);
        const auto* edges = reinterpret_cast<const char*>(tree.edges + features.first_edge);
        for (uint32_t i = 0; i < kMostlyEdges * sizeof(EdgeFeature); i += kLine)
            __builtin_prefetch(edges + i);
        __builtin_prefetch(tree.vertices + features.first_vertex);
    }
};

/// The features of all leaves that a walk has met.
struct FeaturesOfLeaves {
    const KernelScratch& scratch;

    OPENFAB_INLINE FeaturesOfLeaf leaf(size_t i) const {
        return {scratch.leaves.data[i], static_cast<uint32_t>(i) * kLeafPlaces};
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
    FoundFeature feature(int32_t place) const { return found_at(scratch, place); }
    FeatureAnswer answer(int32_t place) const { return answer_of(feature(place)); }
};

/// A packet and what its walk has found; places are those of FeaturesOfLeaves.
template <typename V>
struct SearchOf {
    PointsOf<V> p;
    FeatureBest<V> best;
    V limit;  ///< distance2 with slack; below zero where the lane does not ask
    V slack;  ///< what (r + delta)² is more than r², with r no less than any that is found
};

template <typename V>
OPENFAB_INLINE V limit_of(V distance2, V slack) {
    return distance2 * splat<V>(kSlack) + slack;
}

/// Nothing is found yet: `asked` lanes look as far as start2, mm², which is finite. `delta` is as
/// in kernel.inl, of each lane.
template <typename V>
OPENFAB_INLINE void begin_search(uint32_t asked, V start2, V delta, KernelScratch* scratch,
                                 SearchOf<V>* s) {
    const V r = sqrt(start2);
    s->slack = (r + r + delta) * delta * splat<V>(kSlack * kSlack) + splat<V>(kSlackMm2);
    s->best = nothing_found<V>();
    s->limit = select(Width<V>::mask(asked), limit_of(start2, s->slack), splat<V>(-1.0f));
    scratch->leaves.size = 0;
}

template <typename V>
OPENFAB_INLINE void offer_leaf(const Entry& entry, KernelScratch* scratch, SearchOf<V>* s) {
    const FeaturesOfLeaf leaf(entry, static_cast<uint32_t>(scratch->leaves.size) * kLeafPlaces);
    scratch->leaves.push(entry);
    take_nearest(leaf, s->p, &s->best);
    // The least of both: below zero stays where the lane does not ask, and a radius is never
    // widened.
    s->limit = min(s->limit, limit_of(s->best.distance2, s->slack));
    scratch->counts->triangle_tests += int64_t{leaf.leaf.count()} * V::kLanes / 8;
}

/// One leaf is on its way from memory while a walk goes on to the next.
template <typename V>
struct ComingLeaf {
    Entry entry{nullptr, 0};
    V distance2 = splat<V>(0.0f);  ///< to its box

    OPENFAB_INLINE void offer(KernelScratch* scratch, SearchOf<V>* s) {
        if (entry.tree != nullptr && any(distance2 <= s->limit)) offer_leaf(entry, scratch, s);
        entry.tree = nullptr;
    }
    OPENFAB_INLINE void follow(const Entry& next, V next_distance2, KernelScratch* scratch,
                               SearchOf<V>* s) {
        FeaturesOfLeaf(next, 0).fetch();
        offer(scratch, s);
        entry = next;
        distance2 = next_distance2;
    }
};

/// Searches below the entries `starts`. Nodes wait on the stack with their distances in
/// list_distance2, place for place.
template <typename V>
__attribute__((noinline)) void search(const Entry* starts, size_t count, KernelScratch* scratch,
                                      SearchOf<V>* result) {
    SearchOf<V> local = *result;
    SearchOf<V>* const s = &local;
    scratch->stack.size = 0;
    const auto wait = [&](const Entry& e, V distance2) __attribute__((always_inline)) {
        const size_t place = scratch->stack.size;
        scratch->stack.push(e);
        scratch->list_distance2.reserve(place + 1);
        store(scratch->list_distance2.data[place].v, distance2);
    };
    for (size_t i = 0; i < count; ++i) {
        const V distance2 = node_distance2(starts[i].tree->nodes[starts[i].node], s->p);
        if (bits(distance2 <= s->limit) != 0) wait(starts[i], distance2);
    }
    scratch->counts->node_tests += static_cast<int64_t>(count) * V::kLanes / 8;
    ComingLeaf<V> coming;
    while (scratch->stack.size != 0) {
        const size_t top = --scratch->stack.size;
        const Entry e = scratch->stack.data[top];
        V distance2 = Width<V>::load(scratch->list_distance2.data[top].v);
        if (bits(distance2 <= s->limit) == 0) continue;
        const TreeView* tree = e.tree;
        const Node* node = tree->nodes + e.node;
        while (node != nullptr) {
            if (node->is_leaf() && node->count() == 0) {
                const Node* box = known_box(scratch->patches, *node);
                if (box != nullptr && bits(node_distance2(*box, s->p) <= s->limit) == 0) break;
                tree = scratch->patches.fetch(scratch->patches.context,
                                              static_cast<int32_t>(node->first()));
                node = tree->nodes;
                continue;
            }
            if (node->is_leaf()) {
                coming.follow({tree, static_cast<uint32_t>(node - tree->nodes)}, distance2, scratch,
                              s);
                break;
            }
            V of_child[kMaxChildren];
            const uint32_t near = test_children(*tree, *node, s->p, s->limit, of_child);
            scratch->counts->node_tests += node->children() * V::kLanes / 8;
            const uint32_t child = node->child();
            node = nullptr;
            if (near == 0) break;
            const uint32_t nearest = nearest_child(of_child);
            each_other_child(
                near, nearest, [&](uint32_t i) __attribute__((always_inline)) {
                    wait({tree, child + i}, of_child[i]);
                });
            if ((near >> nearest & 1u) != 0) {
                node = tree->nodes + child + nearest;
                distance2 = of_child[nearest];
            }
        }
    }
    coming.offer(scratch, s);
    *result = local;
}

/// What a lane found is near what the next packet looks for.
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

/// Squared distance to the nearest of the warm points: the answer is no farther.
template <typename V>
OPENFAB_INLINE V warm_distance2(const WarmStart& warm, const PointsOf<V>& p, V start2) {
    for (int i = 0; i < warm.count; ++i) {
        const float at[3] = {warm.point[0][i], warm.point[1][i], warm.point[2][i]};
        start2 = min(start2, distance2_to(at, p));
    }
    return start2;
}
