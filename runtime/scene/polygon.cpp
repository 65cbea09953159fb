// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/polygon.h"

#include <cstddef>
#include <numeric>

namespace openfab::scene {
namespace {

/// Twice the area vector (Newell).
Vec3d area_vector(const std::vector<Vec3d>& p) {
    Vec3d sum;
    for (size_t i = 1; i + 1 < p.size(); ++i)
        sum = sum + cross(p[i] - p[0], p[i + 1] - p[0]);
    return sum;
}

double turn(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& normal) {
    return dot(cross(b - a, c - a), normal);
}

/// Corner i of the ring can be cut off: it turns the polygon's way and no other corner lies in the
/// triangle.
bool is_ear(const std::vector<Vec3d>& p, const std::vector<int32_t>& ring, size_t i,
            const Vec3d& normal) {
    const size_t n = ring.size();
    const auto at = [&](size_t k) -> const Vec3d& { return p[static_cast<size_t>(ring[k % n])]; };
    const Vec3d& a = at(i + n - 1);
    const Vec3d& b = at(i);
    const Vec3d& c = at(i + 1);
    if (!(turn(a, b, c, normal) > 0)) return false;
    for (size_t k = i + 2; k < i + n - 1; ++k) {
        const Vec3d& q = at(k);
        if (q == a || q == b || q == c) continue;
        if (turn(a, b, q, normal) >= 0 && turn(b, c, q, normal) >= 0 && turn(c, a, q, normal) >= 0)
            return false;
    }
    return true;
}

}  // namespace

std::vector<std::array<int32_t, 3>> triangulate(const std::vector<Vec3d>& corners) {
    const size_t n = corners.size();
    std::vector<std::array<int32_t, 3>> out;
    const Vec3d normal = area_vector(corners);
    bool convex = true;
    for (size_t i = 0; i < n && n > 3; ++i) {
        convex =
            convex && turn(corners[i], corners[(i + 1) % n], corners[(i + 2) % n], normal) >= 0;
    }
    if (convex || normal == Vec3d{}) {
        for (size_t i = 1; i + 1 < n; ++i) {
            out.push_back({0, static_cast<int32_t>(i), static_cast<int32_t>(i + 1)});
        }
        return out;
    }
    std::vector<int32_t> ring(n);
    std::iota(ring.begin(), ring.end(), 0);
    while (ring.size() > 3) {
        size_t ear = 0;
        while (ear < ring.size() && !is_ear(corners, ring, ear, normal))
            ++ear;
        // A polygon that crosses itself may have none left; any cut keeps the mesh closed.
        if (ear == ring.size()) ear = 0;
        const size_t m = ring.size();
        out.push_back({ring[(ear + m - 1) % m], ring[ear], ring[(ear + 1) % m]});
        ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    out.push_back({ring[0], ring[1], ring[2]});
    return out;
}

}  // namespace openfab::scene
