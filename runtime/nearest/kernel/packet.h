// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tests of one packet of points, 8 or 16, against boxes and triangles.

#include <cstdint>

#include "base/infinity.h"
#include "runtime/nearest/kernel/kernel.h"
#include "simd/vectors.h"

namespace openfab::nearest::OPENFAB_SIMD_ISA {
namespace {

constexpr float kSlack = 1.0f + 0x1p-18f;
constexpr float kSlackMm2 = 0x1p-40f;

using simd::Floats8;
using simd::Mask8;

/// The points of a packet. V is a vector of floats, one lane per point.
template <typename V>
struct PointsOf {
    V x, y, z;
};
using Points = PointsOf<Floats8>;

OPENFAB_INLINE float larger(float a, float b) {
    return a < b ? b : a;
}

/// A point in a triangle's frame: distance from the plane, and from the edge lines, positive
/// inwards.
template <typename V>
struct InFrameOf {
    V h, s[3];
};
using InFrame = InFrameOf<Floats8>;

OPENFAB_INLINE Floats8 dot3(Floats8 ax, Floats8 ay, Floats8 az, Floats8 bx, Floats8 by,
                            Floats8 bz) {
    return (ax * bx + ay * by) + az * bz;
}

template <typename V>
OPENFAB_INLINE V dot_with(const float* a, V x, V y, V z) {
    return (V(a[0]) * x + V(a[1]) * y) + V(a[2]) * z;
}

/// Returns a . b + c, for pruning tests.
template <typename V>
OPENFAB_INLINE V about_dot(const V* a, const float* b, V c) {
    return about_mul_add(a[0], V(b[0]),
                         about_mul_add(a[1], V(b[1]), about_mul_add(a[2], V(b[2]), c)));
}

/// Returns the distance of each point from the center of the node's box along its axis k.
template <typename V>
OPENFAB_INLINE V along_axis(const Node& n, int k, const PointsOf<V>& p) {
    const float* axis = n.axis[k];
    const V z = about_mul_sub(V(axis[2]), p.z, V(n.center[k]));
    return absolute(about_mul_add(V(axis[0]), p.x, about_mul_add(V(axis[1]), p.y, z)));
}

/// Returns the squared distance of each point to the node's box.
template <typename V>
OPENFAB_INLINE V node_distance2(const Node& n, const PointsOf<V>& p) {
    const V zero = V(0.0f);
    V sum = zero;
    for (int k = 0; k < 3; ++k) {
        const V d = max(along_axis(n, k, p) - V(n.half[k]), zero);
        sum = k == 0 ? d * d : about_mul_add(d, d, sum);
    }
    return sum;
}

/// Computes the squared distances to the children of a node, infinite beyond the last child.
/// Returns the children within `limit` of some lane, bit i for child i.
template <typename V>
OPENFAB_INLINE uint32_t test_children(const TreeView& tree, const Node& node, const PointsOf<V>& p,
                                      V limit, V* distance2) {
    const Node* const child = tree.nodes + node.child();
    uint32_t near = 0;
    for (uint32_t i = 0; i < kMaxChildren; ++i) {
        distance2[i] = V(kInfinity);
        if (i >= node.children()) continue;
        distance2[i] = node_distance2(child[i], p);
        near |= static_cast<uint32_t>(any(distance2[i] <= limit)) << i;
    }
    return near;
}

/// Returns the child that is nearest for most lanes.
template <typename V>
OPENFAB_INLINE uint32_t nearest_child(const V* distance2) {
    const auto nearer = [](V a, V b) OPENFAB_INLINE_LAMBDA {
        return __builtin_popcount(bits(a < b)) > V::kLanes / 2;
    };
    const bool second = nearer(distance2[1], distance2[0]);
    const bool fourth = nearer(distance2[3], distance2[2]);
    const V low = second ? distance2[1] : distance2[0], high = fourth ? distance2[3] : distance2[2];
    return nearer(high, low) ? (fourth ? 3u : 2u) : (second ? 1u : 0u);
}

/// Calls visit(i) for the other children in `near` in reverse order of traversal, as for a stack:
/// the sibling cut from the same part as the nearest is traversed right after it.
template <typename Visit>
OPENFAB_INLINE void each_other_child(uint32_t near, uint32_t nearest, const Visit& visit) {
    for (uint32_t k = 1; k < kMaxChildren; ++k) {
        const uint32_t i = nearest ^ (kMaxChildren - k);
        if ((near >> i & 1u) != 0) visit(i);
    }
}

template <typename V>
OPENFAB_INLINE InFrameOf<V> to_frame(const TriangleFrame& t, const PointsOf<V>& p) {
    const V wx = p.x - V(t.v0[0]), wy = p.y - V(t.v0[1]), wz = p.z - V(t.v0[2]);
    InFrameOf<V> f;
    f.h = dot_with(t.n, wx, wy, wz);
    f.s[0] = dot_with(t.m[0], wx, wy, wz);
    f.s[1] = dot_with(t.m[1], wx, wy, wz) + V(t.height0);
    f.s[2] = dot_with(t.m[2], wx, wy, wz);
    return f;
}

/// An edge from its first end, with the members of EdgeFeature.
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
    typename V::Mask between;  ///< the foot lies between the two ends
};
using AlongEdge = AlongEdgeOf<Floats8>;

/// `Line` has the members of EdgeLine.
template <typename V, typename Line>
OPENFAB_INLINE AlongEdgeOf<V> along_edge(const Line& e, const PointsOf<V>& p) {
    const V ex = V(e.ab[0]), ey = V(e.ab[1]), ez = V(e.ab[2]);
    const V wx = p.x - V(e.a[0]), wy = p.y - V(e.a[1]), wz = p.z - V(e.a[2]);
    const V along = (wx * ex + wy * ey) + wz * ez;
    AlongEdgeOf<V> at;
    at.tau = along * V(e.inv_length2);
    const V qx = wx - at.tau * ex, qy = wy - at.tau * ey, qz = wz - at.tau * ez;
    at.distance2 = (qx * qx + qy * qy) + qz * qz;
    at.between = (V(0.0f) < along) & (along < V(e.length2));
    return at;
}

template <typename V>
OPENFAB_INLINE V distance2_to(const float* v, const PointsOf<V>& p) {
    const V x = p.x - V(v[0]), y = p.y - V(v[1]), z = p.z - V(v[2]);
    return (x * x + y * y) + z * z;
}

/// Returns a lower bound of the squared distance: from the plane, and from the farthest edge line
/// the point is outside of.
OPENFAB_INLINE Floats8 lower_bound(const InFrame& f) {
    const Floats8 beyond = min(min(min(f.s[0], f.s[1]), f.s[2]), Floats8(0.0f));
    return f.h * f.h + beyond * beyond;
}

struct Closest {
    Floats8 distance2, bary1, bary2;
};

/// Returns the approximately nearest point of the triangle in the lanes of `near`; other lanes get
/// some point of it, or infinity.
OPENFAB_INLINE Closest closest_about(const TriangleFrame& t, const TriangleDetail& d,
                                     const Points& p, const InFrame& f, uint32_t near) {
    const Floats8 margin = Floats8(d.margin);
    const Mask8 outside = min(min(f.s[0], f.s[1]), f.s[2]) < margin;
    Closest c;
    c.distance2 = select(outside, Floats8(kInfinity), f.h * f.h);
    c.bary1 = f.s[2] * Floats8(d.inv_height1);
    c.bary2 = f.s[0] * Floats8(d.inv_height2);
    if ((bits(outside) & near) == 0) return c;
    const Floats8 one = Floats8(1.0f), zero = Floats8(0.0f);
    const float* v[4] = {t.v0, d.v1, d.v2, t.v0};
    for (int i = 0; i < 3; ++i) {
        if ((bits(f.s[i] < margin) & near) == 0) continue;
        const AlongEdge at = along_edge(edge_line(v[i], v[i + 1]), p);
        const Mask8 take = at.between & (at.distance2 < c.distance2);
        c.distance2 = select(take, at.distance2, c.distance2);
        c.bary1 = select(take, i == 0 ? at.tau : i == 1 ? one - at.tau : zero, c.bary1);
        c.bary2 = select(take, i == 0 ? zero : i == 1 ? at.tau : one - at.tau, c.bary2);
    }
    for (int i = 0; i < 3; ++i) {
        const Floats8 d2 = distance2_to(v[i], p);
        const Mask8 take = d2 < c.distance2;
        c.distance2 = select(take, d2, c.distance2);
        c.bary1 = select(take, i == 1 ? one : zero, c.bary1);
        c.bary2 = select(take, i == 2 ? one : zero, c.bary2);
    }
    return c;
}

OPENFAB_INLINE float largest_lane(Floats8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = larger(m, v[i]);
    return m;
}

OPENFAB_INLINE float least_lane(Floats8 a) {
    alignas(32) float v[8];
    store(v, a);
    float m = v[0];
    for (int i = 1; i < 8; ++i)
        m = v[i] < m ? v[i] : m;
    return m;
}

/// Returns the voxel centers of packet `packet` of a block and, if V is wide, of the next.
template <typename V>
OPENFAB_INLINE PointsOf<V> voxel_centers(const KernelInput& in, const Vec3i& block, int packet) {
    const float* f = in.frame;
    const BlockShape& s = *in.shape;
    V at[3];
    for (int a = 0; a < 3; ++a) {
        Floats8 parts[V::kLanes / 8];
        for (int h = 0; h < V::kLanes / 8; ++h) {
            parts[h] = Floats8(static_cast<float>(block[a] + s.packet_origin[packet + h][a])) +
                       Floats8::load(s.lane_offset[a]) + Floats8(0.5f);
        }
        at[a] = V::join(parts);
    }
    V c[3];
    for (int a = 0; a < 3; ++a) {
        const float step[3] = {f[OPENFAB_FRAME_STEP_I + a], f[OPENFAB_FRAME_STEP_J + a],
                               f[OPENFAB_FRAME_STEP_K + a]};
        c[a] = dot_with(step, at[0], at[1], at[2]) + V(f[OPENFAB_FRAME_ORIGIN + a]);
    }
    return {c[0], c[1], c[2]};
}

}  // namespace
}  // namespace openfab::nearest::OPENFAB_SIMD_ISA
