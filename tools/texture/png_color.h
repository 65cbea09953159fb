// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a PNG says of its colours. OpenImageIO gives the gamma and some ICC profiles, but calls every PNG
// sRGB, whether it says so or not, and knows nothing of code points and primaries.

#include <array>
#include <cstdint>
#include <optional>

#include "base/input_file.h"
#include "tools/texture/rgb_space.h"

namespace openfab::tools {

/// The chunks before the pixels. A damaged one is not there.
struct PngColor {
    /// cICP: primaries, transfer, matrix, range (ITU-T H.273).
    std::optional<std::array<uint8_t, 4>> code_points;
    int64_t profile_at = 0, profile_bytes = -1;  ///< the data of iCCP; -1: there is none
    bool is_srgb = false;                        ///< sRGB
    std::optional<double> gamma;            ///< gAMA: the exponent of the encoding, 1/2.2 or so
    std::optional<Chromaticities> corners;  ///< cHRM
};

PngColor read_png_color(const InputFile& file);

/// Returns the space of code points; nothing for those that are not supported, which a reader passes
/// over (PNG, third edition, 11.3.2.6).
std::optional<RgbSpace> space_of(const std::array<uint8_t, 4>& code_points);

}  // namespace openfab::tools
