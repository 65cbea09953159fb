// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rays through a mesh, which tell what is inside of what.

#include <cstdint>
#include <limits>
#include <tuple>

#include "mesh/check/triangle_tree.h"
#include "mesh/model/mesh.h"

namespace openfab::mesh {

/// Returns the side of p from the line a b in the y z plane, with p perturbed by (e, e^2): never 0
/// unless a and b coincide there. Equal for both triangles at an edge, since it is computed from
/// the lower end.
inline int side_yz(const Vec3d& a, const Vec3d& b, const Vec3d& p) {
    const bool swapped = std::tie(b.y, b.z) < std::tie(a.y, a.z);
    const Vec3d& lo = swapped ? b : a;
    const Vec3d& hi = swapped ? a : b;
    const double dy = hi.y - lo.y;
    const double dz = hi.z - lo.z;
    double side = dy * (p.z - lo.z) - dz * (p.y - lo.y);
    if (side == 0) side = 0 - dz;
    if (side == 0) side = dy;
    return side == 0 ? 0 : (side > 0) != swapped ? 1 : -1;
}

/// Calls visit(triangle, sign) for each triangle that the ray from p along +x passes: the sum of
/// signs over a closed surface is its winding number at p. Triangles of which skip(triangle) are not
/// looked at. Decreases `*effort` by the triangles whose boxes the ray meets; stops at 0.
template <typename Skip, typename Visit>
void for_each_crossing(const Mesh& mesh, const TriangleTree& tree, const Vec3d& p, int64_t* effort,
                       const Skip& skip, const Visit& visit) {
    Box3d ray;
    ray.add(p);
    ray.hi.x = std::numeric_limits<double>::max();
    tree.for_each_in(ray, [&](int32_t t) {
        if (--*effort < 0) return false;
        if (skip(t)) return true;
        const auto& v = mesh.triangles[t];
        const Vec3d& a = mesh.positions[v[0]];
        const Vec3d& b = mesh.positions[v[1]];
        const Vec3d& c = mesh.positions[v[2]];
        const int side = side_yz(a, b, p);
        if (side == 0 || side_yz(b, c, p) != side || side_yz(c, a, p) != side) return true;
        const Vec3d n = cross(b - a, c - a);
        // The plane's x at p is a.x - (n.y dy + n.z dz) / n.x.
        if (n.x != 0 && a.x - (n.y * (p.y - a.y) + n.z * (p.z - a.z)) / n.x > p.x) visit(t, side);
        return true;
    });
}

}  // namespace openfab::mesh
