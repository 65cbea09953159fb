// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Decodes stored colour values to linear light, without libm, so that pyramids have the same bits
// on every machine.

namespace openfab {

/// Decodes sRGB (IEC 61966-2-1), 0..1 to 0..1; values outside follow the curve's odd extension.
/// Relative error below 1e-14.
double srgb_to_linear(double value);

/// Returns the Rec. 709 luminance of linear values.
inline float luminance(float r, float g, float b) {
    return static_cast<float>(0.2126 * static_cast<double>(r) + 0.7152 * static_cast<double>(g) +
                              0.0722 * static_cast<double>(b));
}

}  // namespace openfab
