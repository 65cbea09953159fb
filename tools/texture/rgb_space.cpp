// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/rgb_space.h"

#include <cmath>
#include <cstddef>

#include "base/color.h"

namespace openfab::tools {
namespace {

using Matrix = std::array<double, 9>;
using Column = std::array<double, 3>;

/// Bradford's cone responses.
constexpr Matrix kCones = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                           0.0367, 0.0389, -0.0685, 1.0296};

Column times(const Matrix& m, const Column& v) {
    Column out{};
    for (size_t row = 0; row < 3; ++row)
        out[row] = m[3 * row] * v[0] + m[3 * row + 1] * v[1] + m[3 * row + 2] * v[2];
    return out;
}

Matrix times(const Matrix& a, const Matrix& b) {
    Matrix out{};
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column) {
            for (size_t k = 0; k < 3; ++k)
                out[3 * row + column] += a[3 * row + k] * b[3 * k + column];
        }
    }
    return out;
}

Matrix scaled(const Column& factors, Matrix m) {
    for (size_t k = 0; k < 9; ++k)
        m[k] *= factors[k / 3];
    return m;
}

/// Nothing where it has no inverse.
std::optional<Matrix> inverse(const Matrix& m) {
    const auto minor = [&](size_t row, size_t column) {
        const size_t r0 = (row + 1) % 3, r1 = (row + 2) % 3;
        const size_t c0 = (column + 1) % 3, c1 = (column + 2) % 3;
        return m[3 * r0 + c0] * m[3 * r1 + c1] - m[3 * r0 + c1] * m[3 * r1 + c0];
    };
    const double determinant = m[0] * minor(0, 0) + m[1] * minor(0, 1) + m[2] * minor(0, 2);
    constexpr double kLeast = 1e-9;
    if (!(std::abs(determinant) > kLeast) || !std::isfinite(determinant)) return std::nullopt;
    Matrix out{};
    for (size_t row = 0; row < 3; ++row) {
        for (size_t column = 0; column < 3; ++column)
            out[3 * row + column] = minor(column, row) / determinant;
    }
    return out;
}

/// X, Y and Z of white, Y = 1; nothing where y is not above 0.
std::optional<Column> white_of(const Chromaticities& c) {
    const double x = c[6], y = c[7];
    if (!(y > 1e-6) || !(x >= 0)) return std::nullopt;
    return Column{x / y, 1, (1 - x - y) / y};
}

/// From linear light to X, Y and Z, white having Y = 1.
std::optional<Matrix> to_xyz(const Chromaticities& c) {
    Matrix primaries{};
    for (size_t k = 0; k < 3; ++k) {
        const double x = c[2 * k], y = c[2 * k + 1];
        primaries[k] = x;
        primaries[3 + k] = y;
        primaries[6 + k] = 1 - x - y;
    }
    const std::optional<Matrix> back = inverse(primaries);
    const std::optional<Column> white = white_of(c);
    if (!back || !white) return std::nullopt;
    const Column amounts = times(*back, *white);
    for (size_t k = 0; k < 9; ++k)
        primaries[k] *= amounts[k % 3];
    return primaries;
}

/// From the XYZ of one white to that of another.
std::optional<Matrix> adaptation(const Column& from, const Column& to) {
    const Column a = times(kCones, from), b = times(kCones, to);
    Column factors{};
    for (size_t k = 0; k < 3; ++k) {
        if (!(std::abs(a[k]) > 1e-9)) return std::nullopt;
        factors[k] = b[k] / a[k];
    }
    const std::optional<Matrix> back = inverse(kCones);
    if (!back) return std::nullopt;
    return times(*back, scaled(factors, kCones));
}

bool is_srgb(const Chromaticities& c) {
    // As files round them, to one in a thousand.
    constexpr double kNear = 1.1e-3;
    for (size_t k = 0; k < c.size(); ++k) {
        if (!(std::abs(c[k] - kSrgbChromaticities[k]) < kNear)) return false;
    }
    return true;
}

}  // namespace

std::optional<RgbSpace> RgbSpace::make(const Chromaticities& chromaticities, Curve curve,
                                       double exponent) {
    RgbSpace out;
    out.curve_ = curve;
    out.exponent_ = exponent;
    out.same_primaries_ = is_srgb(chromaticities);
    if (out.same_primaries_) return out;
    const std::optional<Matrix> here = to_xyz(chromaticities), srgb = to_xyz(kSrgbChromaticities);
    if (!here || !srgb) return std::nullopt;
    const std::optional<Matrix> adapted =
        adaptation(*white_of(chromaticities), *white_of(kSrgbChromaticities));
    const std::optional<Matrix> back = inverse(*srgb);
    if (!adapted || !back) return std::nullopt;
    out.to_srgb_ = times(*back, times(*adapted, *here));
    return out;
}

double RgbSpace::decode(double value) const {
    constexpr double kOne = 1 << 20;
    const auto power = [](double base, double exponent) {
        return std::floor(std::pow(base, exponent) * kOne + 0.5) / kOne;
    };
    switch (curve_) {
        case Curve::kLinear:
            return value;
        case Curve::kSrgb:
            return srgb_to_linear(value);
        case Curve::kPower:
            return value > 0 ? power(value, exponent_) : 0;
        case Curve::kRec709:
            return value < 0.081 ? value / 4.5 : power((value + 0.099) / 1.099, 1 / 0.45);
    }
    return value;
}

void RgbSpace::convert(float* rgb) const {
    if (same_primaries_) return;
    const Column in = {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]),
                       static_cast<double>(rgb[2])};
    const Column out = times(to_srgb_, in);
    for (size_t k = 0; k < 3; ++k)
        rgb[k] = static_cast<float>(out[k]);
}

}  // namespace openfab::tools
