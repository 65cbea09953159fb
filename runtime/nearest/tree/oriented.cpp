// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/nearest/tree/oriented.h"

#include <algorithm>
#include <cmath>

#include "base/principal_axes.h"

namespace openfab::nearest {
namespace {

/// Sets the last axis to the unit vector n and the others to the principal axes across it.
void axes_across(const double cov[6], const Vec3d& n, double axes[3][3]) {
    // Any two directions across (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017).
    const double sign = std::copysign(1.0, n.z);
    const double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    const Vec3d u{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x},
        v{b, sign + n.y * n.y * a, -n.y};
    const auto times = [&](const Vec3d& d) {
        return Vec3d{cov[0] * d.x + cov[1] * d.y + cov[2] * d.z,
                     cov[1] * d.x + cov[3] * d.y + cov[4] * d.z,
                     cov[2] * d.x + cov[4] * d.y + cov[5] * d.z};
    };
    const Vec3d cu = times(u);
    const double uu = dot(u, cu), uv = dot(v, cu), vv = dot(v, times(v));
    const double half = 0.5 * (uu - vv), r = std::sqrt(half * half + uv * uv);
    const double twice = r > 0 ? half / r : 1;
    const double c = std::sqrt(0.5 * (1 + twice)),
                 s = std::copysign(std::sqrt(0.5 * (1 - twice)), uv);
    const Vec3d out[3] = {u * c + v * s, v * c - u * s, n};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
            axes[i][k] = out[i][k];
    }
}

}  // namespace

std::array<Vec3f, 8> OrientedBox::corners() const {
    std::array<Vec3f, 8> out;
    for (int c = 0; c < 8; ++c) {
        Vec3d p;
        for (int k = 0; k < 3; ++k) {
            const double along = (c >> k & 1) != 0 ? hi[k] : lo[k];
            p = p + Vec3d{axis[k][0], axis[k][1], axis[k][2]} * along;
        }
        out[c] = vec_cast<float>(p);
    }
    return out;
}

PrincipalFrame::PrincipalFrame(const Moments& m) {
    const Vec3d mean = m.first * (1.0 / m.weight);
    double cov[6];
    for (int i = 0, k = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j, ++k)
            cov[k] = m.second[k] / m.weight - mean[i] * mean[j];
    }
    // The sum of areas is not useful if they mostly cancel, as those of two faces whose normals are
    // 120 degrees apart, or more.
    constexpr double kFacing = 0.5;
    const double facing = length(m.area);
    if (facing > kFacing * m.weight) {
        axes_across(cov, m.area * (1.0 / facing), axes_);
    } else {
        double a[3][3] = {
            {cov[0], cov[1], cov[2]}, {cov[1], cov[3], cov[4]}, {cov[2], cov[4], cov[5]}};
        // The remainder would turn the axes by a few millionths.
        constexpr double kRest = 1e-6;
        constexpr int kSweeps = 8;
        principal_axes(a, axes_, kRest, kSweeps);
    }
    const auto column = [&](int a) {
        return F4{static_cast<float>(axes_[0][a]), static_cast<float>(axes_[1][a]),
                  static_cast<float>(axes_[2][a]), 0};
    };
    x_ = column(0);
    y_ = column(1);
    z_ = column(2);
    mean_ =
        F4{static_cast<float>(mean.x), static_cast<float>(mean.y), static_cast<float>(mean.z), 0};
}

OrientedBox PrincipalFrame::box(const Range& spread) const {
    OrientedBox out;
    std::copy(&axes_[0][0], &axes_[0][0] + 9, &out.axis[0][0]);
    // The error of a coordinate is less than 2^-21 of its point's distance from the mean.
    const double reach =
        std::max({std::abs(spread.lo[0]), std::abs(spread.hi[0]), std::abs(spread.lo[1]),
                  std::abs(spread.hi[1]), std::abs(spread.lo[2]), std::abs(spread.hi[2])});
    for (int k = 0; k < 3; ++k) {
        const double origin = static_cast<double>(x_[k]) * mean_[0] +
                              static_cast<double>(y_[k]) * mean_[1] +
                              static_cast<double>(z_[k]) * mean_[2];
        out.lo[k] = origin + static_cast<double>(spread.lo[k]) - std::ldexp(reach, -20);
        out.hi[k] = origin + static_cast<double>(spread.hi[k]) + std::ldexp(reach, -20);
    }
    return out;
}

}  // namespace openfab::nearest
