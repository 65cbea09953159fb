// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/up_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/vec.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

/// The minimum ratio of the heights in y and z of a figure with a base, and of one without.
constexpr double kTall = 1.2, kSlim = 1.5;
/// Tolerance relative to the height for being at the bottom, or at 0.
constexpr double kNear = 0.02;
/// The minimum ratio of the base at the lowest y to the flat area at the lowest z.
constexpr double kLarger = 4;

/// Returns the area of the triangles at the lowest coordinate along an axis.
double base_area(const mesh::Mesh& mesh, const Box3d& box, int axis) {
    const double end = box.lo[axis] + kNear * box.size()[axis];
    double area = 0;
    for (const std::array<int32_t, 3>& t : mesh.triangles) {
        const auto p = [&](size_t i) { return mesh.positions[t[i]]; };
        if (std::max({p(0)[axis], p(1)[axis], p(2)[axis]}) > end) continue;
        area += std::abs(cross(p(1) - p(0), p(2) - p(0))[axis]) / 2;
    }
    return area;
}

}  // namespace

std::string y_up_evidence(const mesh::Mesh& mesh) {
    Box3d box;
    for (const std::array<int32_t, 3>& t : mesh.triangles) {
        for (int32_t v : t)
            box.add(mesh.positions[v]);
    }
    if (box.empty()) return {};
    const Vec3d size = box.size();
    if (!(size.z > 0) || size.y < kTall * size.z) return {};
    const double base_y = base_area(mesh, box, 1), base_z = base_area(mesh, box, 2);
    const double ratio = size.y / size.z;
    // A tiny area at the bottom is not a base.
    if (base_y > kLarger * base_z && base_y > kNear * size.x * size.z) {
        return fmt::format(messages::kBaseAtLowestY, ratio);
    }
    const bool on_y = std::abs(box.lo.y) <= kNear * size.y;
    const bool spans_z = box.lo.z < -0.1 * size.z && box.hi.z > 0.1 * size.z;
    if (size.y < kSlim * size.z || !on_y || !spans_z || base_z > base_y) return {};
    return fmt::format(messages::kStandsOnY, ratio);
}

}  // namespace openfab::tools
