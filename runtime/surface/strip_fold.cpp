// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/strip_fold.h"

#include <algorithm>

namespace openfab::surface {

namespace {

Vec3d area_normal(const BaseMesh& base, int32_t triangle) {
    const Vec3d& p = base.position(3 * triangle);
    return cross(base.position(3 * triangle + 1) - p, base.position(3 * triangle + 2) - p);
}

/// Returns the most that a displacement in the box can move along n.
double most_along(const Vec3d& n, const Box3d& box) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis)
        sum += std::max(n[axis] * box.lo[axis], n[axis] * box.hi[axis]);
    return sum;
}

}  // namespace

StripFold::StripFold(const BaseMesh& base, int32_t forward)
    : forward_normal_(area_normal(base, forward / 3)),
      backward_normal_(area_normal(base, base.partner[forward] / 3)) {
    const Vec3d along =
        base.position(base.upper_corner(forward)) - base.position(base.lower_corner(forward));
    const double bend = dot(along, cross(forward_normal_, backward_normal_));
    flat_ = !(bend > 0) && !(bend < 0);
    // From here on the normals point the way that both sides have to move.
    const double sense = bend > 0 ? -1 : 1;
    forward_normal_ = forward_normal_ * sense;
    backward_normal_ = backward_normal_ * sense;
    const double least = base.micro_edge_mm() / 256;
    forward_least_ = least * length(forward_normal_);
    backward_least_ = least * length(backward_normal_);
}

bool StripFold::at(const Vec3f& e, const Vec3f& t, const Vec3f& u) const {
    if (flat_) return false;
    const Vec3d edge = vec_cast<double>(e), moved_t = vec_cast<double>(t),
                moved_u = vec_cast<double>(u);
    const Vec3d apart = moved_t - moved_u;
    return dot(moved_t - edge, forward_normal_) > forward_least_ &&
           dot(moved_u - edge, backward_normal_) > backward_least_ &&
           dot(apart, forward_normal_) > 0 && dot(apart, backward_normal_) < 0;
}

bool StripFold::possible(const Box3d& forward, const Box3d& backward) const {
    // True where a bound overflows.
    return !flat_ && !(most_along(forward_normal_, forward) <= forward_least_) &&
           !(most_along(backward_normal_, backward) <= backward_least_);
}

}  // namespace openfab::surface
