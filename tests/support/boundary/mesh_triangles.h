// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The triangles of meshes of voxels.

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <string>

#include "base/vec.h"
#include "tests/support/boundary/voxel_meshes.h"

namespace openfab::testing {

using Triangle = std::array<Vec3i, 3>;

inline int64_t cross2(int64_t ax, int64_t ay, int64_t bx, int64_t by) {
    return ax * by - ay * bx;
}

inline Vec3<int64_t> doubled_area(const Triangle& t) {
    const auto a = vec_cast<int64_t>(t[1] - t[0]), b = vec_cast<int64_t>(t[2] - t[0]);
    return cross(a, b);
}

inline Triangle corners(const CollectedMesh& mesh, const std::array<uint32_t, 3>& triangle) {
    return {mesh.points[triangle[0]], mesh.points[triangle[1]], mesh.points[triangle[2]]};
}

inline std::string text(const Vec3i& p) {
    return fmt::format("({}, {}, {})", p.x, p.y, p.z);
}

}  // namespace openfab::testing
