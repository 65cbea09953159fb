// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/strip.h"

namespace openfab::reference {

namespace {

using enum StripPlace;
using Corner = StripTriangle::Corner;

Vec3d normal_of(const std::array<Vec3d, 3>& face) {
    return cross(face[1] - face[0], face[2] - face[0]);
}

/// The signed distance, times the length of n, from the plane through `on` to p.
double above(const Vec3f& p, const Vec3f& on, const Vec3d& n) {
    return dot(vec_cast<double>(p) - vec_cast<double>(on), n);
}

}  // namespace

bool is_folded(const StripEdge& edge, const StripPoint& p) {
    const Vec3d up = normal_of(edge.up_face), down = normal_of(edge.down_face);
    const double bend = dot(edge.high - edge.low, cross(up, down));
    const double up_least = edge.micro_edge_mm / 256 * length(up);
    const double down_least = edge.micro_edge_mm / 256 * length(down);
    const double up_moved = above(p.up, p.edge, up), down_moved = above(p.down, p.edge, down);
    const double up_over_down = above(p.up, p.down, down), down_over_up = above(p.down, p.up, up);
    if (bend > 0) {  // convex: both inwards, each outside the other's moved plane
        return up_moved < -up_least && down_moved < -down_least && up_over_down > 0 &&
               down_over_up > 0;
    }
    if (bend < 0) {  // concave: the same from the other side of the surface
        return up_moved > up_least && down_moved > down_least && up_over_down < 0 &&
               down_over_up < 0;
    }
    return false;
}

std::vector<StripTriangle> strip_triangles(const StripEdge& edge,
                                           const std::vector<StripPoint>& points) {
    std::vector<StripTriangle> out;
    const auto add = [&](int32_t quad, Corner a, Corner b, Corner c, int32_t ints_from, auto ints) {
        out.push_back({quad, {a, b, c}, ints_from, ints});
    };
    const auto lower = StripTriangle::kOfLower;
    const auto of_up = StripTriangle::kOfUp, of_down = StripTriangle::kOfDown;
    const auto folded = [&](int32_t i) { return is_folded(edge, points[i]); };
    const int32_t last = static_cast<int32_t>(points.size()) - 1;
    // What closes the vertices meets strips that are not folded there.
    if (folded(0)) add(0, {kUp, 0}, {kDown, 0}, {kEdgeUp, 0}, 0, lower);
    for (int32_t i = 0; i < last; ++i) {
        const int32_t n = i + 1;
        if (!folded(i) && !folded(n)) {
            add(i, {kUp, n}, {kUp, i}, {kDown, i}, i, lower);
            add(i, {kUp, n}, {kDown, i}, {kDown, n}, i, lower);
        } else if (folded(i) && folded(n)) {
            add(i, {kUp, n}, {kUp, i}, {kEdgeUp, i}, i, of_up);
            add(i, {kUp, n}, {kEdgeUp, i}, {kEdgeUp, n}, i, of_up);
            add(i, {kEdgeDown, n}, {kEdgeDown, i}, {kDown, i}, i, of_down);
            add(i, {kEdgeDown, n}, {kDown, i}, {kDown, n}, i, of_down);
        } else {  // a fan from the place on the edge
            const int32_t at = folded(i) ? i : n;
            add(i, {kUp, n}, {kUp, i}, {kEdgeUp, at}, i, of_up);
            if (at == i) {
                add(i, {kUp, n}, {kEdgeUp, i}, {kDown, n}, i, lower);
                add(i, {kDown, n}, {kEdgeDown, i}, {kDown, i}, i, of_down);
            } else {
                add(i, {kEdgeUp, n}, {kUp, i}, {kDown, i}, i, lower);
                add(i, {kEdgeDown, n}, {kDown, i}, {kDown, n}, i, of_down);
            }
        }
    }
    if (folded(last)) add(last - 1, {kDown, last}, {kUp, last}, {kEdgeUp, last}, last, lower);
    return out;
}

}  // namespace openfab::reference
