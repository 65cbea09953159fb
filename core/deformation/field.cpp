// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "deformation/field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace openfab::deformation {

namespace {

/// The node below a place along one axis, and how far it is to the next, 0 to 1.
struct Place {
    int32_t node, next;
    double share;
};

Place place_of(double at, int32_t nodes) {
    const double inside = std::clamp(at, 0.0, static_cast<double>(nodes - 1));
    const auto node = std::min(static_cast<int32_t>(inside), std::max(nodes - 2, 0));
    return {node, std::min(node + 1, nodes - 1), inside - node};
}

}  // namespace

Vec3d Field::displacement(const Vec3d& p_mm) const {
    const Place x = place_of((p_mm.x - origin_mm.x) / spacing_mm.x, nodes.x);
    const Place y = place_of((p_mm.y - origin_mm.y) / spacing_mm.y, nodes.y);
    const Place z = place_of((p_mm.z - origin_mm.z) / spacing_mm.z, nodes.z);
    Vec3d sum;
    for (const auto& [k, wz] : {std::pair{z.node, 1 - z.share}, std::pair{z.next, z.share}}) {
        for (const auto& [j, wy] : {std::pair{y.node, 1 - y.share}, std::pair{y.next, y.share}}) {
            sum = sum + u_mm[at(x.node, j, k)] * (wz * wy * (1 - x.share)) +
                  u_mm[at(x.next, j, k)] * (wz * wy * x.share);
        }
    }
    return sum;
}

std::optional<Vec3d> Field::moved_back(const Vec3d& p_mm) const {
    constexpr double kNear_mm = 1e-7;
    constexpr int kMostSteps = 200;
    Vec3d q = p_mm - displacement(p_mm);
    for (int step = 0; step < kMostSteps; ++step) {
        const Vec3d off = p_mm - moved(q);
        if (std::max({std::fabs(off.x), std::fabs(off.y), std::fabs(off.z)}) < kNear_mm) return q;
        q = q + off;
    }
    return std::nullopt;
}

double Field::steepest() const {
    double most = 0;
    for (int32_t z = 0; z < nodes.z; ++z) {
        for (int32_t y = 0; y < nodes.y; ++y) {
            for (int32_t x = 0; x < nodes.x; ++x) {
                const Vec3i here{x, y, z};
                for (int axis = 0; axis < 3; ++axis) {
                    if (here[axis] + 1 >= nodes[axis]) continue;
                    Vec3i next = here;
                    ++next[axis];
                    const Vec3d d = u_mm[at(next.x, next.y, next.z)] - u_mm[at(x, y, z)];
                    most = std::max(
                        most, std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) / spacing_mm[axis]);
                }
            }
        }
    }
    return most;
}

}  // namespace openfab::deformation
