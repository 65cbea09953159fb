// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace openfab {
namespace {

/// Fifth root of a > 0 by Newton's iteration from above, where it falls until rounding stops it.
double fifth_root(double a) {
    double x = a > 1 ? a : 1;
    for (int step = 0; step < 400; ++step) {
        const double x2 = x * x;
        const double next = (4 * x + a / (x2 * x2)) / 5;
        if (!(next < x)) break;
        x = next;
    }
    return x;
}

}  // namespace

double srgb_to_linear(double value) {
    if (value < 0) return 0 - srgb_to_linear(0 - value);
    if (value <= 0.04045) return value / 12.92;
    const double base = (value + 0.055) / 1.055;
    const double square = base * base;
    return square * fifth_root(square);  // base^2.4 = base^2 (base^2)^(1/5)
}

double linear_to_srgb(double value) {
    const double low = std::max(value, 0.0);
    return low <= 0.0031308 ? low * 12.92 : 1.055 * std::pow(low, 1 / 2.4) - 0.055;
}

uint8_t linear_to_srgb8(double value) {
    // thresholds[i] is midway, in sRGB, between i and i + 1.
    static const std::array<double, 255> kThresholds = [] {
        std::array<double, 255> t{};
        for (size_t i = 0; i < t.size(); ++i)
            t[i] = srgb_to_linear((static_cast<double>(i) + 0.5) / 255);
        return t;
    }();
    return static_cast<uint8_t>(std::upper_bound(kThresholds.begin(), kThresholds.end(), value) -
                                kThresholds.begin());
}

}  // namespace openfab
