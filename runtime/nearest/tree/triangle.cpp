// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/triangle.h"

#include <cmath>
#include <limits>

#include "base/infinity.h"
#include "runtime/nearest/tree/vec_arrays.h"

namespace openfab::nearest {
namespace {

bool comes_before(const Vec3f& a, const Vec3f& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    return a.z < b.z;
}

/// Returns (x + y) + z: the order of every sum of three products here and in the kernel.
float dot3(const Vec3f& a, const Vec3f& b) {
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

void update(float distance2, float bary1, float bary2, Hit* best) {
    if (distance2 < best->distance2) *best = {distance2, bary1, bary2};
}

/// Updates `best` with edge `i` = (first, second), if p is nearest to a point between its ends.
void update_edge(int i, const Vec3f& first, const Vec3f& second, bool swapped, const Vec3f& p,
                 Hit* best) {
    const Vec3f& a = swapped ? second : first;
    const Vec3f& b = swapped ? first : second;
    const Vec3f ab = b - a;
    const Vec3f w = p - a;
    const float length2 = dot3(ab, ab);
    const float along = dot3(w, ab);
    if (!(along > 0.0f && along < length2)) return;
    const float tau = along * (1.0f / length2);
    const Vec3f q = {w.x - tau * ab.x, w.y - tau * ab.y, w.z - tau * ab.z};
    const float to_second = swapped ? 1.0f - tau : tau;
    const float to_first = swapped ? tau : 1.0f - tau;
    update(dot3(q, q),
           i == 0   ? to_second
           : i == 1 ? to_first
                    : 0.0f,
           i == 0   ? 0.0f
           : i == 1 ? to_second
                    : to_first,
           best);
}

}  // namespace

void make_triangle(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, int32_t patch,
                   int32_t triangle, TriangleFrame* frame, TriangleDetail* detail) {
    const Vec3f v[3] = {v0, v1, v2};
    const Vec3d d[3] = {vec_cast<double>(v0), vec_cast<double>(v1), vec_cast<double>(v2)};
    Vec3d edge[3];
    double length2[3];
    double longest2 = 0;
    *frame = {};
    *detail = {};
    for (int i = 0; i < 3; ++i) {
        edge[i] = d[(i + 1) % 3] - d[i];
        length2[i] = dot(edge[i], edge[i]);
        longest2 = std::max(longest2, length2[i]);
        frame->v0[i] = v0[i];
        detail->v1[i] = v1[i];
        detail->v2[i] = v2[i];
        if (comes_before(v[(i + 1) % 3], v[i])) detail->flags |= 1u << i;
    }
    detail->patch = patch;
    detail->triangle = triangle;
    detail->margin = std::max(static_cast<float>(std::ldexp(std::sqrt(longest2), -23)),
                              std::numeric_limits<float>::min());

    const Vec3d normal = cross(edge[0], edge[1]);
    const double area2 = std::sqrt(dot(normal, normal));
    // A triangle thinner than 2^-36 of its length counts as its edges; that is far below the
    // resolution of float positions.
    if (!(area2 > std::ldexp(longest2, -36))) return;
    const Vec3d n = normal * (1.0 / area2);
    store(n, frame->n);
    Vec3d m[3];
    for (int i = 0; i < 3; ++i) {
        m[i] = cross(n, edge[i]) * (1.0 / std::sqrt(length2[i]));
        store(m[i], frame->m[i]);
    }
    frame->height0 = static_cast<float>(dot(m[1], d[0] - d[1]));
    detail->inv_height1 = static_cast<float>(1.0 / dot(m[2], d[1] - d[0]));
    detail->inv_height2 = static_cast<float>(1.0 / dot(m[0], d[2] - d[0]));
}

Hit closest_point(const TriangleFrame& frame, const TriangleDetail& detail, const Vec3f& p) {
    const Vec3f v[3] = {to_vec(frame.v0), to_vec(detail.v1), to_vec(detail.v2)};
    const Vec3f w = p - v[0];
    const float h = dot3(to_vec(frame.n), w);
    const float s[3] = {dot3(to_vec(frame.m[0]), w), dot3(to_vec(frame.m[1]), w) + frame.height0,
                        dot3(to_vec(frame.m[2]), w)};
    Hit best{kInfinity, 0, 0};
    if (s[0] >= detail.margin && s[1] >= detail.margin && s[2] >= detail.margin)
        best = {h * h, s[2] * detail.inv_height1, s[0] * detail.inv_height2};
    for (int i = 0; i < 3; ++i)
        update_edge(i, v[i], v[(i + 1) % 3], (detail.flags >> i & 1u) != 0, p, &best);
    for (int i = 0; i < 3; ++i) {
        const Vec3f q = p - v[i];
        update(dot3(q, q), i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f, &best);
    }
    return best;
}

}  // namespace openfab::nearest
