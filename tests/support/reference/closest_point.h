// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The closest point on a triangle, in double: the reference for distances in float.

#include <algorithm>

#include "base/vec.h"

namespace openfab::reference {

/// Returns the point of triangle (a, b, c) closest to p; a triangle without area counts as its
/// edges.
inline Vec3d closest_point(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const auto on_segment = [&](const Vec3d& s, const Vec3d& e) {
        const double l2 = dot(e - s, e - s);
        const double t = l2 > 0 ? std::clamp(dot(p - s, e - s) / l2, 0.0, 1.0) : 0.0;
        return s + (e - s) * t;
    };
    const Vec3d n = cross(b - a, c - a);
    if (dot(n, n) > 0) {
        const Vec3d q = p - n * (dot(n, p - a) / dot(n, n));
        const bool inside = dot(n, cross(b - a, q - a)) >= 0 && dot(n, cross(c - b, q - b)) >= 0 &&
                            dot(n, cross(a - c, q - c)) >= 0;
        if (inside) return q;
    }
    Vec3d best = on_segment(a, b);
    for (const Vec3d& q : {on_segment(b, c), on_segment(c, a)}) {
        if (dot(p - q, p - q) < dot(p - best, p - best)) best = q;
    }
    return best;
}

}  // namespace openfab::reference
