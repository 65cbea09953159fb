// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/rotation.h"

#include <cmath>

#include "base/check.h"

namespace openfab {
namespace {

constexpr double kRadiansPerDegree = 0.017453292519943295;

// Taylor series; at 45 degrees the first term left out is below 1e-18.
double sin_small(double x) {
    const double x2 = x * x;
    double sum = 1;
    for (int n = 18; n >= 2; n -= 2)
        sum = 1 - sum * x2 / static_cast<double>(n * (n + 1));
    return x * sum;
}

double cos_small(double x) {
    const double x2 = x * x;
    double sum = 1;
    for (int n = 17; n >= 1; n -= 2)
        sum = 1 - sum * x2 / static_cast<double>(n * (n + 1));
    return sum;
}

std::array<double, 9> product(const std::array<double, 9>& a, const std::array<double, 9>& b) {
    std::array<double, 9> out{};
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            out[i * 3 + j] = a[i * 3] * b[j] + a[i * 3 + 1] * b[3 + j] + a[i * 3 + 2] * b[6 + j];
        }
    }
    return out;
}

}  // namespace

SinCos sin_cos_degrees(double degrees) {
    OPENFAB_CHECK(std::isfinite(degrees));
    const double turned = std::fmod(degrees, 360.0);  // exact
    const double quarter = std::floor(turned / 90.0 + 0.5);
    const double x = (turned - quarter * 90.0) * kRadiansPerDegree;  // the difference is exact
    const double s = sin_small(x);
    const double c = cos_small(x);
    switch ((static_cast<int>(quarter) % 4 + 4) % 4) {
        case 0:
            return {s, c};
        case 1:
            return {c, 0 - s};
        case 2:
            return {0 - s, 0 - c};
        default:
            return {0 - c, s};
    }
}

Affine3d placement_transform(const Vec3d& scale, const Vec3d& rotate_deg,
                             const Vec3d& translate_mm) {
    const SinCos x = sin_cos_degrees(rotate_deg.x);
    const SinCos y = sin_cos_degrees(rotate_deg.y);
    const SinCos z = sin_cos_degrees(rotate_deg.z);
    const std::array<double, 9> rx{1, 0, 0, 0, x.cos, 0 - x.sin, 0, x.sin, x.cos};
    const std::array<double, 9> ry{y.cos, 0, y.sin, 0, 1, 0, 0 - y.sin, 0, y.cos};
    const std::array<double, 9> rz{z.cos, 0 - z.sin, 0, z.sin, z.cos, 0, 0, 0, 1};
    Affine3d out{product(rz, product(ry, rx)), translate_mm};
    for (size_t i = 0; i < 9; ++i)
        out.m[i] = out.m[i] * scale[static_cast<int>(i % 3)];
    return out;
}

}  // namespace openfab
