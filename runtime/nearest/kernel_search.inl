// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The nearest triangles of a packet of points by one walk down the hierarchy, each lane with its
// own limit. Part of kernel.inl.

/// A packet and what its walk has found.
template <typename V>
struct SearchOf {
    PointsOf<V> p;
    V distance2, x, y;
    V winner;  ///< as bits: see found_at
    V limit;   ///< distance2 with slack; below zero where the lane does not ask
    V slack;   ///< what (r + delta)² is more than r², with r no less than any that is found
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
    s->distance2 = splat<V>(kNoFeature);
    s->x = s->y = splat<V>(0.0f);
    s->winner = Width<V>::splat_bits(0);
    s->limit = select(Width<V>::mask(asked), limit_of(start2, s->slack), splat<V>(-1.0f));
    scratch->leaves.size = 0;
}

/// Where a feature ties with what was found, the one that comes first wins.
template <typename V>
__attribute__((noinline)) void break_tie(int32_t place, uint32_t equal, V x, V y,
                                         const KernelScratch& scratch, SearchOf<V>* s) {
    constexpr int kLanes = V::kLanes;
    alignas(64) float at_x[kLanes], at_y[kLanes], of_x[kLanes], of_y[kLanes];
    alignas(64) int32_t winner[kLanes];
    store(at_x, s->x);
    store(at_y, s->y);
    store(of_x, x);
    store(of_y, y);
    store_bits(winner, s->winner);
    const FeatureAnswer answer = answer_of(found_at(scratch, place));
    for (; equal != 0; equal &= equal - 1) {
        const int l = __builtin_ctz(equal);
        if (!comes_first(answer, answer_of(found_at(scratch, winner[l])))) continue;
        winner[l] = place;
        at_x[l] = of_x[l];
        at_y[l] = of_y[l];
    }
    s->x = Width<V>::load(at_x);
    s->y = Width<V>::load(at_y);
    s->winner = Width<V>::load(reinterpret_cast<const float*>(winner));
}

template <typename V>
OPENFAB_INLINE void offer(int32_t place, V distance2, V x, V y, const KernelScratch& scratch,
                          SearchOf<V>* s) {
    const auto closer = distance2 < s->distance2;
    const uint32_t equal = bits(distance2 == s->distance2);
    if (__builtin_expect(equal != 0, 0)) {
        // A copy, so that what the loops hold stays in registers.
        SearchOf<V> copy = *s;
        break_tie(place, equal, x, y, scratch, &copy);
        *s = copy;
    }
    s->distance2 = min(s->distance2, distance2);
    s->x = select(closer, x, s->x);
    s->y = select(closer, y, s->y);
    s->winner = select(closer, Width<V>::splat_bits(place), s->winner);
}

template <typename V>
OPENFAB_INLINE void offer_leaf(const Entry& entry, KernelScratch* scratch, SearchOf<V>* s) {
    const V infinity = splat<V>(kInfinity), zero = splat<V>(0.0f);
    const TreeView& tree = *entry.tree;
    const Node& leaf = tree.nodes[entry.node];
    const uint32_t first = leaf.first(), end = first + leaf.count();
    auto place = static_cast<int32_t>(scratch->leaves.size * kLeafPlaces);
    scratch->leaves.push(entry);
    for (uint32_t i = first; i < end; ++i, ++place) {
        const InFrameOf<V> f = to_frame(tree.frames[i], s->p);
        const auto inside = splat<V>(tree.details[i].margin) <= min(min(f.s[0], f.s[1]), f.s[2]);
        offer(place, select(inside, f.h * f.h, infinity), f.s[2], f.s[0], *scratch, s);
    }
    const uint32_t edges_end = tree.first_edge[end];
    for (uint32_t i = tree.first_edge[first]; i < edges_end; ++i, ++place) {
        const AlongEdgeOf<V> at = along_edge(tree.edges[i], s->p);
        offer(place, select(at.between, at.distance2, infinity), at.tau, at.tau, *scratch, s);
    }
    const uint32_t vertices_end = tree.first_vertex[end];
    for (uint32_t i = tree.first_vertex[first]; i < vertices_end; ++i, ++place)
        offer(place, distance2_to(tree.vertices[i].v, s->p), zero, zero, *scratch, s);
    // The least of both: below zero stays where the lane does not ask, and a radius is never
    // widened.
    s->limit = min(s->limit, limit_of(s->distance2, s->slack));
    scratch->counts->triangle_tests += int64_t{leaf.count()} * V::kLanes / 8;
}

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
    while (scratch->stack.size != 0) {
        const size_t top = --scratch->stack.size;
        const Entry e = scratch->stack.data[top];
        const V waited = Width<V>::load(scratch->list_distance2.data[top].v);
        if (bits(waited <= s->limit) == 0) continue;
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
                offer_leaf({tree, static_cast<uint32_t>(node - tree->nodes)}, scratch, s);
                break;
            }
            const Node* left = tree->nodes + node->child();
            const V dl = node_distance2(left[0], s->p), dr = node_distance2(left[1], s->p);
            scratch->counts->node_tests += 2 * V::kLanes / 8;
            const bool go_left = bits(dl <= s->limit) != 0, go_right = bits(dr <= s->limit) != 0;
            if (go_left && go_right) {
                const bool right_first = __builtin_popcount(bits(dr < dl)) > V::kLanes / 2;
                wait({tree, node->child() + (right_first ? 0u : 1u)}, right_first ? dl : dr);
                node = left + (right_first ? 1 : 0);
            } else {
                node = go_left ? left : go_right ? left + 1 : nullptr;
            }
        }
    }
    *result = local;
}

/// Calls each(lane, feature, distance2, answer, bary1, bary2) for the lanes of `found`.
template <typename V, typename Each>
OPENFAB_INLINE void each_found(const SearchOf<V>& s, uint32_t found, const KernelScratch& scratch,
                               const Each& each) {
    constexpr int kLanes = V::kLanes;
    alignas(64) float d2[kLanes], x[kLanes], y[kLanes];
    alignas(64) int32_t winner[kLanes];
    store(d2, s.distance2);
    store(x, s.x);
    store(y, s.y);
    store_bits(winner, s.winner);
    // Most lanes found what the one before did.
    FoundFeature feature;
    FeatureAnswer a;
    for (int32_t last = -1; found != 0; found &= found - 1) {
        const int l = __builtin_ctz(found);
        if (winner[l] != last) {
            last = winner[l];
            feature = found_at(scratch, last);
            a = answer_of(feature);
        }
        each(l, feature, d2[l], a, a.bary1 + a.bary1_x * x[l], a.bary2 + a.bary2_y * y[l]);
    }
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
