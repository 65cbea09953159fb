// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Stored colour values and linear light. What decides bits of a print or of a picture does without libm,
// so that it is the same on every machine.

#include <cstdint>

namespace openfab {

/// Decodes sRGB (IEC 61966-2-1), 0..1 to 0..1; values outside follow the curve's odd extension.
/// Relative error below 1e-14.
double srgb_to_linear(double value);

/// Encodes linear light by the same curve; values below 0 become 0. By libm: for people to read.
double linear_to_srgb(double value);

/// Returns the 8-bit sRGB value nearest to a linear one, which is clamped to 0..1; without libm.
uint8_t linear_to_srgb8(double value);

/// Returns the Rec. 709 luminance of linear values.
inline float luminance(float r, float g, float b) {
    return static_cast<float>(0.2126 * static_cast<double>(r) + 0.7152 * static_cast<double>(g) +
                              0.0722 * static_cast<double>(b));
}

}  // namespace openfab
