// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/reference/inside.h"

#include <cmath>
#include <utility>

namespace openfab::reference {

namespace {

__extension__ typedef __int128 Wide;

/// Sign of c0 + c1 e + c2 e² + c3 e³ for an infinitesimal e > 0.
int sign(std::initializer_list<Wide> coefficients) {
    for (const Wide c : coefficients) {
        if (c != 0) return c > 0 ? 1 : -1;
    }
    return 0;
}

/// Returns +1 or -1, by its orientation, if the line along x through the sample meets the triangle,
/// else 0. `n` receives the triangle's normal.
int meets(const SnappedTriangle& t, const Vec3<int64_t>& center, Vec3<Wide>* n) {
    const Vec3<Wide> a = vec_cast<Wide>(t[0]), b = vec_cast<Wide>(t[1]), c = vec_cast<Wide>(t[2]);
    *n = cross(b - a, c - a);
    const int facing = sign({n->x});
    for (size_t e = 0; e < 3; ++e) {
        const Vec3<int64_t>&p = t[e], &q = t[(e + 1) % 3];
        const Wide dy = q.y - p.y, dz = q.z - p.z;
        // Twice the (y, z) area of p, q and the sample (y + e², z + e³).
        const int left = sign({dy * (center.z - p.z) - dz * (center.y - p.y), 0, -dz, dy});
        if (left != facing) return 0;
    }
    return facing;
}

}  // namespace

Vec3<int64_t> snap(const Affine3d& local_to_voxel, const Vec3d& point) {
    const Vec3d v = local_to_voxel.apply(point);
    return {static_cast<int64_t>(std::floor(256 * v.x + 0.5)),
            static_cast<int64_t>(std::floor(256 * v.y + 0.5)),
            static_cast<int64_t>(std::floor(256 * v.z + 0.5))};
}

std::vector<SnappedTriangle> snap_triangles(const Affine3d& local_to_voxel,
                                            const std::vector<std::array<Vec3f, 3>>& triangles) {
    std::vector<std::array<Vec3d, 3>> doubles;
    for (const auto& t : triangles) {
        doubles.push_back({vec_cast<double>(t[0]), vec_cast<double>(t[1]), vec_cast<double>(t[2])});
    }
    return snap_triangles(local_to_voxel, doubles);
}

std::vector<SnappedTriangle> snap_triangles(const Affine3d& local_to_voxel,
                                            const std::vector<std::array<Vec3d, 3>>& triangles) {
    const auto& m = local_to_voxel.m;
    const Vec3d x{m[0], m[3], m[6]}, y{m[1], m[4], m[7]}, z{m[2], m[5], m[8]};
    const bool mirrors = dot(cross(x, y), z) < 0;
    std::vector<SnappedTriangle> out;
    for (const auto& t : triangles) {
        out.push_back(
            {snap(local_to_voxel, t[0]), snap(local_to_voxel, t[1]), snap(local_to_voxel, t[2])});
        if (mirrors) std::swap(out.back()[1], out.back()[2]);
    }
    return out;
}

int32_t winding(const std::vector<SnappedTriangle>& triangles, const Vec3i& voxel) {
    const Vec3<int64_t> center{256ll * voxel.x + 128, 256ll * voxel.y + 128, 256ll * voxel.z + 128};
    int32_t sum = 0;
    for (const SnappedTriangle& t : triangles) {
        Vec3<Wide> n;
        const int facing = meets(t, center, &n);
        if (facing == 0) continue;
        // The sample must lie on the -x side of the triangle's plane.
        const Vec3<Wide> d = vec_cast<Wide>(center - t[0]);
        if (sign({dot(n, d), n.x, n.y, n.z}) == -facing) sum += facing;
    }
    return sum;
}

std::vector<uint8_t> inside(const std::vector<SnappedTriangle>& triangles, const Vec3i& size) {
    std::vector<uint8_t> out;
    out.reserve(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) *
                static_cast<size_t>(size.z));
    std::vector<SnappedTriangle> row;
    for (int32_t k = 0; k < size.z; ++k) {
        for (int32_t j = 0; j < size.y; ++j) {
            // Whether the line of a row meets a triangle is the same for all voxels of the row.
            row.clear();
            Vec3<Wide> n;
            for (const SnappedTriangle& t : triangles) {
                if (meets(t, {128, 256ll * j + 128, 256ll * k + 128}, &n) != 0) row.push_back(t);
            }
            for (int32_t i = 0; i < size.x; ++i)
                out.push_back(winding(row, {i, j, k}) > 0 ? 1 : 0);
        }
    }
    return out;
}

}  // namespace openfab::reference
