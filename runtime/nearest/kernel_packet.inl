// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// One packet: 8 points against boxes and triangles. Part of kernel.inl.

constexpr float kSlack = 1.0f + 0x1p-18f;
constexpr float kSlackMm2 = 0x1p-40f;
constexpr float kInfinity = __builtin_inff();

/// V is a vector of floats, one lane a point.
template <typename V>
struct PointsOf {
    V x, y, z;
};
using Points = PointsOf<F8>;

OPENFAB_INLINE float larger(float a, float b) {
    return a < b ? b : a;
}

/// Squared distance of each point to the node's box.
OPENFAB_INLINE F8 node_distance2(const Node& n, const Points& p) {
    const F8 zero = set1(0.0f);
    F8 sum;
    for (int k = 0; k < 3; ++k) {
        const F8 u =
            dot3(set1(n.axis[k][0]), set1(n.axis[k][1]), set1(n.axis[k][2]), p.x, p.y, p.z);
        const F8 d = max(absolute(u - set1(n.center[k])) - set1(n.half[k]), zero);
        sum = k == 0 ? d * d : sum + d * d;
    }
    return sum;
}

/// A point in a triangle's frame: distance from the plane, and from the edge lines, positive
/// inwards.
template <typename V>
struct InFrameOf {
    V h, s[3];
};
using InFrame = InFrameOf<F8>;

template <typename V>
OPENFAB_INLINE V dot_with(const float* a, V x, V y, V z) {
    return (splat<V>(a[0]) * x + splat<V>(a[1]) * y) + splat<V>(a[2]) * z;
}

template <typename V>
OPENFAB_INLINE InFrameOf<V> to_frame(const TriangleFrame& t, const PointsOf<V>& p) {
    const V wx = p.x - splat<V>(t.v0[0]), wy = p.y - splat<V>(t.v0[1]),
            wz = p.z - splat<V>(t.v0[2]);
    InFrameOf<V> f;
    f.h = dot_with(t.n, wx, wy, wz);
    f.s[0] = dot_with(t.m[0], wx, wy, wz);
    f.s[1] = dot_with(t.m[1], wx, wy, wz) + splat<V>(t.height0);
    f.s[2] = dot_with(t.m[2], wx, wy, wz);
    return f;
}

/// What the edge of `offer_edge` in triangle.cpp is made of, from its first end.
struct EdgeLine {
    float a[3], ab[3];
    float length2, inv_length2;
};

OPENFAB_INLINE EdgeLine edge_line(const float* a, const float* b) {
    EdgeLine e;
    for (int k = 0; k < 3; ++k) {
        e.a[k] = a[k];
        e.ab[k] = b[k] - a[k];
    }
    e.length2 = (e.ab[0] * e.ab[0] + e.ab[1] * e.ab[1]) + e.ab[2] * e.ab[2];
    e.inv_length2 = 1.0f / e.length2;
    return e;
}

template <typename V>
struct AlongEdgeOf {
    V distance2, tau;
    MaskOf<V> between;  ///< the two ends
};
using AlongEdge = AlongEdgeOf<F8>;

/// `Line` has the members of EdgeLine.
template <typename V, typename Line>
OPENFAB_INLINE AlongEdgeOf<V> along_edge(const Line& e, const PointsOf<V>& p) {
    const V ex = splat<V>(e.ab[0]), ey = splat<V>(e.ab[1]), ez = splat<V>(e.ab[2]);
    const V wx = p.x - splat<V>(e.a[0]), wy = p.y - splat<V>(e.a[1]), wz = p.z - splat<V>(e.a[2]);
    const V along = (wx * ex + wy * ey) + wz * ez;
    AlongEdgeOf<V> at;
    at.tau = along * splat<V>(e.inv_length2);
    const V qx = wx - at.tau * ex, qy = wy - at.tau * ey, qz = wz - at.tau * ez;
    at.distance2 = (qx * qx + qy * qy) + qz * qz;
    at.between = (splat<V>(0.0f) < along) & (along < splat<V>(e.length2));
    return at;
}

template <typename V>
OPENFAB_INLINE V distance2_to(const float* v, const PointsOf<V>& p) {
    const V x = p.x - splat<V>(v[0]), y = p.y - splat<V>(v[1]), z = p.z - splat<V>(v[2]);
    return (x * x + y * y) + z * z;
}

/// A lower bound of the squared distance: to the plane, and to the farthest edge line that the
/// point is outside of.
OPENFAB_INLINE F8 lower_bound(const InFrame& f) {
    const F8 beyond = min(min(min(f.s[0], f.s[1]), f.s[2]), set1(0.0f));
    return f.h * f.h + beyond * beyond;
}

struct Closest {
    F8 distance2, bary1, bary2;
};

/// `closest_point` in the lanes of `near`; others get the distance to some point of the triangle,
/// or infinity. With `exact` off any point of the triangle that is about the nearest will do.
template <bool exact>
OPENFAB_INLINE Closest closest8(const TriangleFrame& t, const TriangleDetail& d, const Points& p,
                                const InFrame& f, uint32_t near) {
    const F8 margin = set1(d.margin);
    const F8 inwards = min(min(f.s[0], f.s[1]), f.s[2]);
    const M8 outside = inwards < margin;
    Closest c;
    c.distance2 = select(outside, set1(kInfinity), f.h * f.h);
    c.bary1 = f.s[2] * set1(d.inv_height1);
    c.bary2 = f.s[0] * set1(d.inv_height2);
    // So far inside the face an edge is farther by more than rounding: s² > 2^-16 (h² + longest²).
    const M8 shared =
        exact ? inwards < absolute(f.h) * set1(0x1p-8f) + margin * set1(0x1p15f) : outside;
    if ((bits(shared) & near) == 0) return c;
    const F8 one = set1(1.0f), zero = set1(0.0f);
    const float* v[4] = {t.v0, d.v1, d.v2, t.v0};
    for (int i = 0; i < 3; ++i) {
        if (!exact && (bits(f.s[i] < margin) & near) == 0) continue;
        const bool swapped = (d.flags >> i & 1u) != 0;
        const EdgeLine e = edge_line(swapped ? v[i + 1] : v[i], swapped ? v[i] : v[i + 1]);
        const AlongEdge at = along_edge(e, p);
        const M8 take = at.between & (at.distance2 < c.distance2);
        const F8 to_second = swapped ? one - at.tau : at.tau;
        const F8 to_first = swapped ? at.tau : one - at.tau;
        c.distance2 = select(take, at.distance2, c.distance2);
        c.bary1 = select(take, i == 0 ? to_second : i == 1 ? to_first : zero, c.bary1);
        c.bary2 = select(take, i == 0 ? zero : i == 1 ? to_second : to_first, c.bary2);
    }
    for (int i = 0; i < 3; ++i) {
        const F8 d2 = distance2_to(v[i], p);
        const M8 take = d2 < c.distance2;
        c.distance2 = select(take, d2, c.distance2);
        c.bary1 = select(take, i == 1 ? one : zero, c.bary1);
        c.bary2 = select(take, i == 2 ? one : zero, c.bary2);
    }
    return c;
}
OPENFAB_INLINE float largest_lane(F8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = larger(m, v[i]);
    return m;
}

OPENFAB_INLINE float least_lane(F8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = v[i] < m ? v[i] : m;
    return m;
}

/// What a packet of 8 voxels has found.
struct PacketBest {
    F8 distance2, bary1, bary2;
    F8 patch, triangle;  ///< as bits; the largest int where there is none
    F8 limit;            ///< distance2 with slack; below zero where the lane does not ask
};

/// `delta` as in kernel.inl, of each lane.
OPENFAB_INLINE F8 packet_limit(F8 distance2, F8 delta) {
    const F8 r = sqrt(distance2) + delta;
    return r * r * set1(kSlack) + set1(kSlackMm2);
}

/// Returns the lanes that the triangle wins, as a mask.
OPENFAB_INLINE M8 improve(const TriangleRef& ref, const InFrame& f, uint32_t near, const Points& p,
                          F8 delta, PacketBest* best) {
    const Closest c = closest8<true>(*ref.frame, *ref.detail, p, f, near);
    const F8 patch = set1_bits(ref.detail->patch), triangle = set1_bits(ref.detail->triangle);
    const M8 earlier = less_bits(patch, best->patch) |
                       (equal_bits(patch, best->patch) & less_bits(triangle, best->triangle));
    const M8 better =
        (c.distance2 < best->distance2) | ((c.distance2 == best->distance2) & earlier);
    if (bits(better) == 0) return better;
    best->distance2 = select(better, c.distance2, best->distance2);
    best->bary1 = select(better, c.bary1, best->bary1);
    best->bary2 = select(better, c.bary2, best->bary2);
    best->patch = select(better, patch, best->patch);
    best->triangle = select(better, triangle, best->triangle);
    // The least of both: below zero stays where the lane does not ask, and a radius is never
    // widened.
    best->limit = min(best->limit, packet_limit(best->distance2, delta));
    return better;
}

/// A packet that has found nothing yet: `asked` lanes look as far as start2, mm².
OPENFAB_INLINE PacketBest empty_packet(uint32_t asked, F8 start2, F8 delta) {
    PacketBest best;
    best.distance2 = set1(kInfinity);
    best.patch = best.triangle = set1_bits(INT32_MAX);
    best.bary1 = best.bary2 = set1(0.0f);
    best.limit = select(mask_of(asked), packet_limit(start2, delta), set1(-1.0f));
    return best;
}
