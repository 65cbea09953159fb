// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nearest feature for each point of a packet.
//
// `Features` below provides the features. It has faces(visit), edges(visit) and vertices(visit),
// which call visit(frame, margin, index), visit(edge, index) and visit(position, index) for each,
// and answer(index), the answer where that feature wins. Indices are its own.

#include <cstdint>

#include "runtime/nearest/kernel/answers.h"
#include "runtime/nearest/kernel/packet.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

/// The nearest features of a packet so far.
template <typename V>
struct FeatureBest {
    V distance2, x, y;  ///< x and y: position in the feature, as in FeatureAnswer
    typename V::Ints index;
    typename V::Mask tied;  ///< another feature has the same distance2
};

template <typename V>
OPENFAB_INLINE FeatureBest<V> nothing_found() {
    const V zero = V(0.0f);
    return {V(kNoFeature), zero, zero, typename V::Ints(0), zero < zero};
}

/// Returns the lanes whose feature is within the radius.
template <typename V>
OPENFAB_INLINE uint32_t found_within(const FeatureBest<V>& best, V radius2) {
    return bits((best.distance2 <= radius2) & (best.distance2 < V(kNoFeature)));
}

/// Calls visit(index, distance2, x, y) for every feature; distance2 is infinite where the nearest
/// point of its triangles lies in another feature.
template <typename V, typename Features, typename Visit>
OPENFAB_INLINE void each_feature(const Features& features, const PointsOf<V>& p,
                                 const Visit& visit) {
    const V infinity = V(kInfinity), zero = V(0.0f);
    features.faces([&](const TriangleFrame& frame, float margin, uint32_t index)
                       OPENFAB_INLINE_LAMBDA {
                           const InFrameOf<V> f = to_frame(frame, p);
                           const auto inside = V(margin) <= min(min(f.s[0], f.s[1]), f.s[2]);
                           visit(index, select(inside, f.h * f.h, infinity), f.s[2], f.s[0]);
                       });
    features.edges([&](const EdgeFeature& edge, uint32_t index) OPENFAB_INLINE_LAMBDA {
        const AlongEdgeOf<V> at = along_edge(edge, p);
        visit(index, select(at.between, at.distance2, infinity), at.tau, at.tau);
    });
    features.vertices([&](const float* v, uint32_t index)
                          OPENFAB_INLINE_LAMBDA { visit(index, distance2_to(v, p), zero, zero); });
}

template <typename V, typename Features>
OPENFAB_INLINE void update_nearest(const Features& features, const PointsOf<V>& p,
                                   FeatureBest<V>* best) {
    each_feature(features, p, [best](uint32_t index, V distance2, V x, V y) OPENFAB_INLINE_LAMBDA {
        const auto closer = distance2 < best->distance2;
        best->tied = andnot(closer, best->tied) | (distance2 == best->distance2);
        best->distance2 = min(best->distance2, distance2);
        best->x = select(closer, x, best->x);
        best->y = select(closer, y, best->y);
        best->index = select(closer, typename V::Ints(static_cast<int32_t>(index)), best->index);
    });
}

/// Resolves ties in the lanes of `active`: the feature that is first by (patch, triangle, order)
/// wins.
template <typename V, typename Features>
__attribute__((noinline)) void break_ties(const Features& features, const PointsOf<V>& p,
                                          uint32_t active, FeatureBest<V>* best) {
    constexpr int kLanes = V::kLanes;
    alignas(64) float x[kLanes], y[kLanes], at_x[kLanes], at_y[kLanes];
    alignas(64) int32_t winner[kLanes];
    store(x, best->x);
    store(y, best->y);
    store(winner, best->index);
    const uint32_t tied = bits(best->tied) & active;
    each_feature(features, p, [&](uint32_t index, V distance2, V of_x, V of_y) {
        uint32_t equal = bits(distance2 == best->distance2) & tied;
        if (equal == 0) return;
        store(at_x, of_x);
        store(at_y, of_y);
        const FeatureAnswer now = features.answer(static_cast<int32_t>(index));
        for (; equal != 0; equal &= equal - 1) {
            const int l = __builtin_ctz(equal);
            if (!comes_first(now, features.answer(winner[l]))) continue;
            winner[l] = static_cast<int32_t>(index);
            x[l] = at_x[l];
            y[l] = at_y[l];
        }
    });
    best->x = V::load(x);
    best->y = V::load(y);
    best->index = V::Ints::load(winner);
}

/// Calls each(lane, index, answer, distance2, bary1, bary2) for the lanes of `found`.
template <typename V, typename Features, typename Each>
OPENFAB_INLINE void each_found(const Features& features, const FeatureBest<V>& best, uint32_t found,
                               const Each& each) {
    constexpr int kLanes = V::kLanes;
    alignas(64) float d2[kLanes], x[kLanes], y[kLanes];
    alignas(64) int32_t index[kLanes];
    store(d2, best.distance2);
    store(x, best.x);
    store(y, best.y);
    store(index, best.index);
    for (; found != 0; found &= found - 1) {
        const int l = __builtin_ctz(found);
        const FeatureAnswer& a = features.answer(index[l]);
        each(l, index[l], a, d2[l], a.bary1 + a.bary1_x * x[l], a.bary2 + a.bary2_y * y[l]);
    }
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
