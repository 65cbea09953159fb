// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// One packet: 8 points against boxes and triangles. Part of kernel.inl.

constexpr float kSlack = 1.0f + 0x1p-18f;
constexpr float kSlackMm2 = 0x1p-40f;
constexpr float kInfinity = __builtin_inff();

struct Points {
    F8 x, y, z;
};

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
struct InFrame {
    F8 h, s[3];
};

OPENFAB_INLINE InFrame to_frame(const TriangleFrame& t, const Points& p) {
    const F8 wx = p.x - set1(t.v0[0]), wy = p.y - set1(t.v0[1]), wz = p.z - set1(t.v0[2]);
    InFrame f;
    f.h = dot3(set1(t.n[0]), set1(t.n[1]), set1(t.n[2]), wx, wy, wz);
    f.s[0] = dot3(set1(t.m[0][0]), set1(t.m[0][1]), set1(t.m[0][2]), wx, wy, wz);
    f.s[1] = dot3(set1(t.m[1][0]), set1(t.m[1][1]), set1(t.m[1][2]), wx, wy, wz) + set1(t.height0);
    f.s[2] = dot3(set1(t.m[2][0]), set1(t.m[2][1]), set1(t.m[2][2]), wx, wy, wz);
    return f;
}

/// A lower bound of the squared distance: to the plane, and to the farthest edge line that the
/// point is outside of.
OPENFAB_INLINE F8 lower_bound(const InFrame& f) {
    const F8 beyond = min(min(min(f.s[0], f.s[1]), f.s[2]), set1(0.0f));
    return f.h * f.h + beyond * beyond;
}

/// `closest_on_edge` of triangle.cpp; `from_first` is 0 at f and 1 at s.
OPENFAB_INLINE F8 closest_on_edge(const float* f, const float* s, bool swapped, const Points& p,
                                  F8* from_first) {
    const float* a = swapped ? s : f;
    const float* b = swapped ? f : s;
    const float abx = b[0] - a[0], aby = b[1] - a[1], abz = b[2] - a[2];
    const F8 one = set1(1.0f);
    const F8 ex = set1(abx), ey = set1(aby), ez = set1(abz);
    const F8 wx = p.x - set1(a[0]), wy = p.y - set1(a[1]), wz = p.z - set1(a[2]);
    const F8 length2 = set1((abx * abx + aby * aby) + abz * abz);
    // A quotient rounds to 1 or more exactly where `along` is not below `length2`.
    const F8 tau = min(max(dot3(wx, wy, wz, ex, ey, ez) / length2, set1(0.0f)), one);
    F8 qx = wx - tau * ex, qy = wy - tau * ey, qz = wz - tau * ez;
    const F8 at_b = tau == one;
    qx = select(at_b, p.x - set1(b[0]), qx);
    qy = select(at_b, p.y - set1(b[1]), qy);
    qz = select(at_b, p.z - set1(b[2]), qz);
    *from_first = swapped ? one - tau : tau;
    return dot3(qx, qy, qz, qx, qy, qz);
}

struct Closest {
    F8 distance2, bary1, bary2;
};

/// `closest_point` in the lanes of `near`; others get the distance to some point of the triangle,
/// or infinity.
OPENFAB_INLINE Closest closest8(const TriangleFrame& t, const TriangleDetail& d, const Points& p,
                                const InFrame& f, uint32_t near) {
    const F8 margin = set1(d.margin);
    const F8 outside = min(min(f.s[0], f.s[1]), f.s[2]) < margin;
    Closest c;
    c.distance2 = select(outside, set1(kInfinity), f.h * f.h);
    c.bary1 = f.s[2] * set1(d.inv_height1);
    c.bary2 = f.s[0] * set1(d.inv_height2);
    if ((bits(outside) & near) == 0) return c;
    const F8 one = set1(1.0f), zero = set1(0.0f);
    const float* v[4] = {t.v0, d.v1, d.v2, t.v0};
    for (int i = 0; i < 3; ++i) {
        const F8 beyond = f.s[i] < margin;
        if ((bits(beyond) & near) == 0) continue;
        F8 along;
        const F8 e = closest_on_edge(v[i], v[i + 1], (d.flags >> i & 1u) != 0, p, &along);
        const F8 take = (e < c.distance2) & beyond;
        c.distance2 = select(take, e, c.distance2);
        const F8 b1 = i == 0 ? along : i == 1 ? one - along : zero;
        const F8 b2 = i == 0 ? zero : i == 1 ? along : one - along;
        c.bary1 = select(take, b1, c.bary1);
        c.bary2 = select(take, b2, c.bary2);
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

OPENFAB_INLINE F8 mask_of(uint32_t bits8) {
    alignas(32) float lanes[8];
    for (int l = 0; l < 8; ++l)
        lanes[l] = (bits8 >> l & 1u) != 0 ? -1.0f : 1.0f;
    return load(lanes) < set1(0.0f);
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
OPENFAB_INLINE F8 improve(const TriangleRef& ref, const InFrame& f, uint32_t near, const Points& p,
                          F8 delta, PacketBest* best) {
    const Closest c = closest8(*ref.frame, *ref.detail, p, f, near);
    const F8 patch = set1_bits(ref.detail->patch), triangle = set1_bits(ref.detail->triangle);
    const F8 earlier = less_bits(patch, best->patch) |
                       (equal_bits(patch, best->patch) & less_bits(triangle, best->triangle));
    const F8 better =
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

__attribute__((noinline)) void query_packet(const TriangleRef* refs, size_t count, const Points& p,
                                            uint32_t asked, float delta, KernelScratch* scratch,
                                            PacketBest* result) {
    Lanes* bounds = scratch->bounds.data;
    Lanes* framed = scratch->framed.data;
    PacketBest best = *result;
    const F8 slack = set1(delta);
    // First a lower bound for every triangle, without a branch; then the triangle that promises
    // most to each lane; then only those whose bound is still below what was found.
    F8 least = set1(kInfinity), promising = set1_bits(0);
    for (size_t i = 0; i < count; ++i) {
        const InFrame f = to_frame(*refs[i].frame, p);
        const F8 bound = lower_bound(f);
        store(framed[4 * i].v, f.h);
        store(framed[4 * i + 1].v, f.s[0]);
        store(framed[4 * i + 2].v, f.s[1]);
        store(framed[4 * i + 3].v, f.s[2]);
        store(bounds[i].v, bound);
        promising = select(bound < least, set1_bits(static_cast<int32_t>(i)), promising);
        least = min(least, bound);
    }
    const auto try_triangle = [&](size_t i) {
        const uint32_t near = bits(load(bounds[i].v) <= best.limit);
        if (near == 0) return;
        const InFrame f{
            load(framed[4 * i].v),
            {load(framed[4 * i + 1].v), load(framed[4 * i + 2].v), load(framed[4 * i + 3].v)}};
        improve(refs[i], f, near, p, slack, &best);
    };
    alignas(32) int32_t first[8];
    store_bits(first, promising);
    for (int l = 0; l < 8; ++l) {
        const auto i = static_cast<size_t>(first[l]);
        if ((asked >> l & 1u) == 0 || bounds[i].v[0] == kInfinity) continue;
        try_triangle(i);
        store(bounds[i].v, set1(kInfinity));
    }
    for (size_t i = 0; i < count; i += 4) {
        const F8 b0 = load(bounds[i].v), b1 = load(bounds[i + 1].v);
        const F8 b2 = load(bounds[i + 2].v), b3 = load(bounds[i + 3].v);
        if (bits(min(min(b0, b1), min(b2, b3)) <= best.limit) == 0) continue;
        for (size_t j = i; j < i + 4 && j < count; ++j)
            try_triangle(j);
    }
    *result = best;
}
