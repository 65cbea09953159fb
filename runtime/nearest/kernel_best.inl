// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The nearest of many features to each point of a packet. Part of kernel.inl.
//
// `Features` below is where they come from. It has faces(visit), edges(visit) and vertices(visit),
// which call visit(frame, margin, place), visit(edge, place) and visit(position, place) for each,
// and winner(place). Places are numbers of its own.

/// What the points of a packet have found.
template <typename V>
struct FeatureBest {
    V distance2;
    V place;         ///< as bits
    MaskOf<V> tied;  ///< another feature has the same distance2
};

template <typename V>
OPENFAB_INLINE FeatureBest<V> nothing_found() {
    const V zero = splat<V>(0.0f);
    return {splat<V>(kNoFeature), Width<V>::splat_bits(0), zero < zero};
}

/// Lanes that have found something no farther.
template <typename V>
OPENFAB_INLINE uint32_t found_within(const FeatureBest<V>& best, V radius2) {
    return bits((best.distance2 <= radius2) & (best.distance2 < splat<V>(kNoFeature)));
}

// Calls visit(place, distance2) for every feature of one kind; distance2 is infinite where the
// feature is not what its triangles are nearest in.

template <typename V, typename Features, typename Visit>
OPENFAB_INLINE void each_face(const Features& features, const PointsOf<V>& p, const Visit& visit) {
    features.faces([&](const TriangleFrame& frame, float margin, uint32_t place)
                       __attribute__((always_inline)) {
                           const InFrameOf<V> f = to_frame(frame, p);
                           const auto inside = splat<V>(margin) <= min(min(f.s[0], f.s[1]), f.s[2]);
                           visit(place, select(inside, f.h * f.h, splat<V>(kInfinity)));
                       });
}

template <typename V, typename Features, typename Visit>
OPENFAB_INLINE void each_edge(const Features& features, const PointsOf<V>& p, const Visit& visit) {
    features.edges([&](const EdgeFeature& edge, uint32_t place) __attribute__((always_inline)) {
        const AlongEdgeOf<V> at = along_edge(edge, p);
        visit(place, select(at.between, at.distance2, splat<V>(kInfinity)));
    });
}

template <typename V, typename Features, typename Visit>
OPENFAB_INLINE void each_vertex(const Features& features, const PointsOf<V>& p,
                                const Visit& visit) {
    features.vertices([&](const float* v, uint32_t place)
                          __attribute__((always_inline)) { visit(place, distance2_to(v, p)); });
}

template <typename V, typename Features, typename Visit>
OPENFAB_INLINE void each_feature(const Features& features, const PointsOf<V>& p,
                                 const Visit& visit) {
    each_face(features, p, visit);
    each_edge(features, p, visit);
    each_vertex(features, p, visit);
}

template <typename V, typename Features>
OPENFAB_INLINE void take_nearest(const Features& features, const PointsOf<V>& p,
                                 FeatureBest<V>* best) {
    each_feature(
        features, p, [best](uint32_t place, V distance2) __attribute__((always_inline)) {
            const auto closer = distance2 < best->distance2;
            best->tied = andnot(closer, best->tied) | (distance2 == best->distance2);
            best->distance2 = min(best->distance2, distance2);
            best->place =
                select(closer, Width<V>::splat_bits(static_cast<int32_t>(place)), best->place);
        });
}

/// Where features tie in the lanes of `asked`, the one that comes first by (patch, triangle,
/// order).
template <typename V, typename Features>
__attribute__((noinline)) void break_ties(const Features& features, const PointsOf<V>& p,
                                          uint32_t asked, FeatureBest<V>* best) {
    alignas(64) int32_t place[V::kLanes];
    store_bits(place, best->place);
    const uint32_t tied = bits(best->tied) & asked;
    each_feature(features, p, [&](uint32_t other, V distance2) {
        uint32_t equal = bits(distance2 == best->distance2) & tied;
        if (equal == 0) return;
        const FeatureAnswer answer = features.winner(static_cast<int32_t>(other)).answer;
        for (; equal != 0; equal &= equal - 1) {
            const int l = __builtin_ctz(equal);
            if (comes_first(answer, features.winner(place[l]).answer))
                place[l] = static_cast<int32_t>(other);
        }
    });
    best->place = Width<V>::load(reinterpret_cast<const float*>(place));
}

/// Calls each(lane, winner, distance2, bary1, bary2) for the lanes of `found`.
template <typename V, typename Features, typename Each>
OPENFAB_INLINE void each_found(const Features& features, const PointsOf<V>& p,
                               const FeatureBest<V>& best, uint32_t found, const Each& each) {
    constexpr int kLanes = V::kLanes;
    alignas(64) float d2[kLanes], x[kLanes], y[kLanes];
    alignas(64) int32_t place[kLanes];
    store(d2, best.distance2);
    store_bits(place, best.place);
    // Most lanes found what the one before did.
    decltype(features.winner(0)) w{};
    for (int32_t last = -1; found != 0; found &= found - 1) {
        const int l = __builtin_ctz(found);
        if (place[l] != last) {
            last = place[l];
            w = features.winner(last);
            const InFeature<V> at = in_feature(w.kind, w.row, p);
            store(x, at.x);
            store(y, at.y);
        }
        const FeatureAnswer& a = w.answer;
        each(l, w, d2[l], a.bary1 + a.bary1_x * x[l], a.bary2 + a.bary2_y * y[l]);
    }
}
