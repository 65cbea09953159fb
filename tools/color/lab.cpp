// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/lab.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace openfab::color {

namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// sRGB's primaries under D65, adapted to D50 by Bradford's matrix.
constexpr Matrix kXyzOfLinear = {{{0.4360747, 0.3850649, 0.1430804},
                                  {0.2225045, 0.7168786, 0.0606169},
                                  {0.0139322, 0.0971045, 0.7141733}}};

Matrix inverse(const Matrix& m) {
    Matrix out{};
    double determinant = 0;
    for (size_t i = 0; i < 3; ++i) {
        for (size_t j = 0; j < 3; ++j) {
            const size_t a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            out[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
        determinant += m[0][i] * out[i][0];
    }
    for (auto& row : out) {
        for (double& value : row)
            value /= determinant;
    }
    return out;
}

std::array<double, 3> apply(const Matrix& m, const std::array<double, 3>& v) {
    std::array<double, 3> out{};
    for (size_t i = 0; i < 3; ++i)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
    return out;
}

// CIE 15: the cube root, and a line below (6 / 29)^3.
constexpr double kEpsilon = 216.0 / 24389.0;
constexpr double kSlope = 841.0 / 108.0;
constexpr double kOffset = 4.0 / 29.0;

double curve(double t) {
    return t > kEpsilon ? std::cbrt(t) : t * kSlope + kOffset;
}

double uncurve(double f) {
    return f > 6.0 / 29.0 ? f * f * f : (f - kOffset) / kSlope;
}

double radians(double degrees) {
    return degrees * (std::numbers::pi / 180);
}

/// In degrees, 0..360; 0 for grey.
double hue(double a, double b) {
    if (a == 0 && b == 0) return 0;
    const double h = std::atan2(b, a) * (180 / std::numbers::pi);
    return h < 0 ? h + 360 : h;
}

}  // namespace

Lab to_lab(const Xyz& xyz, const Xyz& white) {
    const double x = curve(xyz.x / white.x), y = curve(xyz.y / white.y), z = curve(xyz.z / white.z);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Xyz to_xyz(const Lab& lab, const Xyz& white) {
    const double y = (lab.l + 16) / 116;
    return {uncurve(y + lab.a / 500) * white.x, uncurve(y) * white.y,
            uncurve(y - lab.b / 200) * white.z};
}

Xyz xyz_of_linear(const Rgb& linear) {
    const std::array<double, 3> v = apply(kXyzOfLinear, linear);
    return {v[0], v[1], v[2]};
}

Rgb linear_of_xyz(const Xyz& xyz) {
    static const Matrix kInverse = inverse(kXyzOfLinear);
    return apply(kInverse, {xyz.x, xyz.y, xyz.z});
}

double ciede2000(const Lab& one, const Lab& other) {
    constexpr double kTo7th = 6103515625.0;  // 25^7
    const double c1 = std::hypot(one.a, one.b), c2 = std::hypot(other.a, other.b);
    const double mean7 = std::pow((c1 + c2) / 2, 7);
    const double g = 0.5 * (1 - std::sqrt(mean7 / (mean7 + kTo7th)));
    const double a1 = (1 + g) * one.a, a2 = (1 + g) * other.a;
    const double p1 = std::hypot(a1, one.b), p2 = std::hypot(a2, other.b);
    const double h1 = hue(a1, one.b), h2 = hue(a2, other.b);
    const bool grey = p1 * p2 == 0;
    double turn = grey ? 0 : h2 - h1;
    if (turn > 180) turn -= 360;
    if (turn < -180) turn += 360;
    const double dl = other.l - one.l, dc = p2 - p1;
    const double dh = 2 * std::sqrt(p1 * p2) * std::sin(radians(turn / 2));
    const double l = (one.l + other.l) / 2, c = (p1 + p2) / 2;
    double h = h1 + h2;
    if (!grey) {
        const bool apart = std::abs(h1 - h2) > 180;
        h = (apart ? (h < 360 ? h + 360 : h - 360) : h) / 2;
    }
    const double t = 1 - 0.17 * std::cos(radians(h - 30)) + 0.24 * std::cos(radians(2 * h)) +
                     0.32 * std::cos(radians(3 * h + 6)) - 0.20 * std::cos(radians(4 * h - 63));
    const double around_blue = (h - 275) / 25;
    const double theta = 30 * std::exp(-around_blue * around_blue);
    const double c7 = std::pow(c, 7);
    const double rc = 2 * std::sqrt(c7 / (c7 + kTo7th));
    const double l50 = (l - 50) * (l - 50);
    const double sl = 1 + 0.015 * l50 / std::sqrt(20 + l50);
    const double sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
    const double rt = -std::sin(radians(2 * theta)) * rc;
    const double u = dl / sl, v = dc / sc, w = dh / sh;
    return std::sqrt(std::max(u * u + v * v + w * w + rt * v * w, 0.0));
}

}  // namespace openfab::color
