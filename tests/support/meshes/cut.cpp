// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/meshes/cut.h"

namespace openfab::testing {

namespace {

Vec3d rounded(const Vec3d& p) {
    return vec_cast<double>(vec_cast<float>(p));
}

bool before(const Vec3d& a, const Vec3d& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

/// Returns the point where an edge meets the plane, independent of the edge's direction.
Vec3d edge_point(Vec3d a, Vec3d b, const CutPlane& plane) {
    if (before(b, a)) std::swap(a, b);
    const double sa = plane.side(a), sb = plane.side(b);
    return rounded(a + (b - a) * (sa / (sa - sb)));
}

struct Corner {
    Vec3d p;
    bool on_plane;
};

/// Clips a triangle to one side, 1 above and -1 below.
std::vector<Corner> clip(const CutTriangle& t, const CutPlane& plane, int side) {
    std::vector<Corner> out;
    for (size_t c = 0; c < 3; ++c) {
        const Vec3d &a = t[c], &b = t[(c + 1) % 3];
        const double sa = plane.side(a) * side, sb = plane.side(b) * side;
        if (sa >= 0) out.push_back({a, sa == 0});
        if ((sa > 0 && sb < 0) || (sa < 0 && sb > 0))
            out.push_back({edge_point(a, b, plane), true});
    }
    return out;
}

/// From the first corner by position, so that a cap is triangulated alike on both sides.
void add_fan(const std::vector<Corner>& polygon, std::vector<CutTriangle>* out) {
    const size_t n = polygon.size();
    size_t first = 0;
    for (size_t c = 1; c < n; ++c) {
        if (before(polygon[c].p, polygon[first].p)) first = c;
    }
    for (size_t c = 2; c < n; ++c) {
        const CutTriangle t{polygon[first].p, polygon[(first + c - 1) % n].p,
                            polygon[(first + c) % n].p};
        if (!(t[0] == t[1]) && !(t[1] == t[2]) && !(t[2] == t[0])) out->push_back(t);
    }
}

}  // namespace

mesh::Mesh CutPiece::mesh(bool with_caps) const {
    mesh::Mesh out;
    out.name = "piece";
    const auto add = [&](const std::vector<CutTriangle>& triangles) {
        for (const CutTriangle& t : triangles) {
            const auto first = static_cast<int32_t>(out.positions.size());
            out.positions.insert(out.positions.end(), t.begin(), t.end());
            out.triangles.push_back({first, first + 1, first + 2});
        }
    };
    add(outer);
    if (with_caps) add(caps);
    return out;
}

CutPiece whole(const mesh::Mesh& mesh) {
    CutPiece out;
    for (const auto& t : mesh.triangles) {
        out.outer.push_back({rounded(mesh.positions[t[0]]), rounded(mesh.positions[t[1]]),
                             rounded(mesh.positions[t[2]])});
    }
    return out;
}

std::array<CutPiece, 2> cut(const CutPiece& piece, const CutPlane& plane) {
    std::array<CutPiece, 2> out;
    std::vector<std::array<Vec3d, 2>> outline[2];
    const auto cut_all = [&](const std::vector<CutTriangle>& triangles, bool caps) {
        for (const CutTriangle& t : triangles) {
            const bool flat =
                plane.side(t[0]) == 0 && plane.side(t[1]) == 0 && plane.side(t[2]) == 0;
            // Triangles in the plane belong to the piece that they face away from.
            const bool looks_up = dot(cross(t[1] - t[0], t[2] - t[0]), plane.normal) > 0;
            for (size_t k = 0; k < 2; ++k) {
                if (flat && (k == 0) == looks_up) continue;
                const std::vector<Corner> polygon = clip(t, plane, k == 0 ? 1 : -1);
                if (polygon.size() < 3) continue;
                add_fan(polygon, caps ? &out[k].caps : &out[k].outer);
                for (size_t c = 0; c < polygon.size(); ++c) {
                    const Corner &a = polygon[c], &b = polygon[(c + 1) % polygon.size()];
                    if (a.on_plane && b.on_plane && !(a.p == b.p)) outline[k].push_back({a.p, b.p});
                }
            }
        }
    };
    cut_all(piece.outer, false);
    cut_all(piece.caps, true);
    // In the plane and inside a convex outline, unlike the center of its box.
    Vec3d middle;
    for (const auto& edge : outline[0])
        middle = middle + edge[0] * (1 / static_cast<double>(outline[0].size()));
    middle = rounded(middle);
    for (size_t k = 0; k < 2; ++k) {
        for (const auto& [a, b] : outline[k]) {
            if (!(a == middle) && !(b == middle)) out[k].caps.push_back({middle, b, a});
        }
    }
    return out;
}

}  // namespace openfab::testing
