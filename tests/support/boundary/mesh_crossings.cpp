// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/support/boundary/mesh_triangles.h"
#include "tests/support/boundary/voxel_meshes.h"

namespace openfab::testing {

namespace {

/// Six times the volume of the tetrahedron, above 0 where d sees a, b, c clockwise.
int64_t side_of(const Vec3i& a, const Vec3i& b, const Vec3i& c, const Vec3i& d) {
    const auto v = [&](const Vec3i& p) { return vec_cast<int64_t>(p - a); };
    return dot(cross(v(b), v(c)), v(d));
}

int sign(int64_t x) {
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

/// Returns the two axes of the projection with the largest area.
std::array<int, 2> axes_of(const Triangle& t) {
    const Vec3<int64_t> area = doubled_area(t);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
        axis = std::abs(area[a]) > std::abs(area[axis]) ? a : axis;
    return {(axis + 1) % 3, (axis + 2) % 3};
}

/// Returns whether a triangle and a segment, which share no vertex, meet.
bool meets(const Triangle& t, const Vec3i& p, const Vec3i& q) {
    const int sp = sign(side_of(t[0], t[1], t[2], p)), sq = sign(side_of(t[0], t[1], t[2], q));
    if (sp * sq > 0) return false;
    if (sp != 0 || sq != 0) {
        const int s0 = sign(side_of(p, q, t[0], t[1])), s1 = sign(side_of(p, q, t[1], t[2])),
                  s2 = sign(side_of(p, q, t[2], t[0]));
        return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
    }
    const auto [u, v] = axes_of(t);
    const auto turn = [u = u, v = v](const Vec3i& a, const Vec3i& b, const Vec3i& c) {
        return sign(cross2(b[u] - a[u], b[v] - a[v], c[u] - a[u], c[v] - a[v]));
    };
    // Coplanar: they meet unless a side of the triangle, or the segment, separates them.
    for (size_t i = 0; i < 3; ++i) {
        const Vec3i &a = t[i], &b = t[(i + 1) % 3], &c = t[(i + 2) % 3];
        const int inner = turn(a, b, c);
        if (turn(a, b, p) * inner < 0 && turn(a, b, q) * inner < 0) return false;
    }
    const int s0 = turn(p, q, t[0]), s1 = turn(p, q, t[1]), s2 = turn(p, q, t[2]);
    return !((s0 > 0 && s1 > 0 && s2 > 0) || (s0 < 0 && s1 < 0 && s2 < 0));
}

/// Returns whether a segment from a triangle's first vertex runs in its plane and between its other
/// two.
bool runs_inside(const Triangle& t, const Vec3i& q) {
    if (side_of(t[0], t[1], t[2], q) != 0) return false;
    const auto [u, v] = axes_of(t);
    const auto turn = [&, u = u, v = v](const Vec3i& b, const Vec3i& c) {
        return sign(cross2(b[u] - t[0][u], b[v] - t[0][v], c[u] - t[0][u], c[v] - t[0][v]));
    };
    const int inner = turn(t[1], t[2]);
    return turn(t[1], q) * inner >= 0 && turn(q, t[2]) * inner >= 0;
}

/// Returns whether a side of one triangle goes through another, not only up to it.
bool goes_through(const Triangle& from, const Triangle& t) {
    for (size_t i = 0; i < 3; ++i) {
        const Vec3i &p = from[i], &q = from[(i + 1) % 3];
        const int sp = sign(side_of(t[0], t[1], t[2], p)), sq = sign(side_of(t[0], t[1], t[2], q));
        if (sp * sq >= 0) continue;
        const int s0 = sign(side_of(p, q, t[0], t[1])), s1 = sign(side_of(p, q, t[1], t[2])),
                  s2 = sign(side_of(p, q, t[2], t[0]));
        if (s0 != 0 && s0 == s1 && s1 == s2) return true;
    }
    return false;
}

bool boxes_meet(const Triangle& a, const Triangle& b) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto [alo, ahi] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
        const auto [blo, bhi] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
        if (ahi < blo || bhi < alo) return false;
    }
    return true;
}

/// Returns whether a side of the triangle `from` meets the triangle `with` where it must not.
bool pierces(const CollectedMesh& mesh, const std::array<uint32_t, 3>& from,
             const std::array<uint32_t, 3>& with) {
    for (size_t i = 0; i < 3; ++i) {
        uint32_t p = from[i], q = from[(i + 1) % 3];
        const auto position_of = [&](uint32_t v) { return std::find(with.begin(), with.end(), v); };
        if (position_of(p) == with.end()) std::swap(p, q);
        const auto shared = position_of(p);
        if (shared == with.end()) {
            if (meets(corners(mesh, with), mesh.points[p], mesh.points[q])) return true;
        } else if (position_of(q) == with.end()) {
            std::array<uint32_t, 3> turned = with;
            std::rotate(turned.begin(), turned.begin() + (shared - with.begin()), turned.end());
            if (runs_inside(corners(mesh, turned), mesh.points[q])) return true;
        }
    }
    return false;
}

/// Returns the first pair of triangles of two meshes whose boxes meet and that are `wrong`.
template <typename Wrong>
std::string check_pairs(const CollectedMesh& one, const CollectedMesh& two, const Wrong& wrong) {
    Box3i box;
    for (const Vec3i& p : one.points)
        box.add(p);
    const Vec3i size = box.hi - box.lo;
    const int along = size.x >= std::max(size.y, size.z) ? 0 : size.y >= size.z ? 1 : 2;
    const auto low = [&](const CollectedMesh& mesh, const std::array<uint32_t, 3>& t) {
        const Triangle c = corners(mesh, t);
        return std::min({c[0][along], c[1][along], c[2][along]});
    };
    std::vector<std::array<uint32_t, 3>> sorted = two.triangles;
    std::sort(sorted.begin(), sorted.end(),
              [&](const auto& a, const auto& b) { return low(two, a) < low(two, b); });
    for (const std::array<uint32_t, 3>& t : one.triangles) {
        const Triangle a = corners(one, t);
        const int32_t high = std::max({a[0][along], a[1][along], a[2][along]});
        for (const std::array<uint32_t, 3>& other : sorted) {
            if (low(two, other) > high) break;
            const Triangle b = corners(two, other);
            if (boxes_meet(a, b) && wrong(t, other))
                return fmt::format("the triangles at {} and {} cross", text(a[0]), text(b[0]));
        }
    }
    return {};
}

}  // namespace

std::string check_crossings(const CollectedMesh& mesh) {
    return check_pairs(mesh, mesh,
                       [&](const auto& a, const auto& b) { return a != b && pierces(mesh, a, b); });
}

std::string check_crossings(const CollectedMesh& one, const CollectedMesh& two) {
    return check_pairs(one, two, [&](const auto& a, const auto& b) {
        return goes_through(corners(one, a), corners(two, b));
    });
}

}  // namespace openfab::testing
