// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Encodes PNG files. libpng drives zlib row by row, which is several times slower on slices than
// libdeflate over the whole picture; tests read the files back through libpng.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openfab::raster {

enum class PngColor : uint8_t { kGrey = 0, kRgb = 2, kIndexed = 3, kRgba = 6 };

struct PngImage {
    int32_t width = 0;
    int32_t height = 0;
    PngColor color = PngColor::kRgba;
    int32_t bits =
        8;  ///< a channel or index; 4 only where indexed, the first pixel in the high half
    /// Top row first; each row is a filter byte, 0, and then its pixels: height * (1 + ceil(width *
    /// bits * channels / 8)).
    std::span<const uint8_t> rows;
    /// kIndexed: RGBA for each index.
    std::vector<std::array<uint8_t, 4>> palette;
    double pixels_per_metre_x = 0;  ///< 0: none given
    double pixels_per_metre_y = 0;
    std::string text;  ///< "Software" entry, empty for none
};

/// Encodes a PNG file; empty where memory ran out.
std::vector<uint8_t> encode_png(const PngImage& image, int level);

/// Decodes the rows of a file that encode_png made, at any level, from an image like `image`, whose
/// own rows are ignored. Empty where the file is anything else, or truncated.
std::vector<uint8_t> decode_png(std::span<const uint8_t> file, const PngImage& image);

}  // namespace openfab::raster
