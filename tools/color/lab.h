// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Colours as people see them: CIE XYZ and Lab under D50, as ICC profiles and instruments for prints
// have them, and the difference between two of them.

#include <array>

namespace openfab::color {

/// Tristimulus values, Y = 1 for a perfect white.
struct Xyz {
    double x = 0, y = 0, z = 0;
};

/// L* 0..100, a* and b* about -128..127.
struct Lab {
    double l = 0, a = 0, b = 0;
};

/// Red, green, blue with the primaries of sRGB.
using Rgb = std::array<double, 3>;

/// The white of the profile connection space (ICC.1, 7.2.16).
constexpr Xyz kD50{0.9642, 1.0, 0.8249};

Lab to_lab(const Xyz& xyz, const Xyz& white = kD50);
Xyz to_xyz(const Lab& lab, const Xyz& white = kD50);

/// Converts linear light, adapted from D65 to D50 by Bradford's method; white is kD50 to a
/// thousandth.
Xyz xyz_of_linear(const Rgb& linear);
/// Returns the inverse; colours that sRGB does not have are below 0 or above 1.
Rgb linear_of_xyz(const Xyz& xyz);

/// Returns CIEDE2000 with all weights 1, after Sharma, Wu and Dalal, "The CIEDE2000
/// color-difference formula: implementation notes, supplementary test data, and mathematical
/// observations", Color Research & Application 30(1), 2005.
double ciede2000(const Lab& one, const Lab& other);

}  // namespace openfab::color
