// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Encodes PNG files: pictures for people by libdeflate, which makes them small, and slices by ISA-L,
// which compresses long runs as fast as they are made. libpng drives zlib row by row, which is an
// order of magnitude slower on slices; tests read the files back through libpng.

#include <array>
#include <cstdint>
#include <functional>
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

/// Encodes a PNG file, with libdeflate at `level`; empty where memory ran out.
std::vector<uint8_t> encode_png(const PngImage& image, int level);

/// Writes row `y` of a picture, 0 at its top, without the filter byte.
using PutRow = std::function<void(int32_t y, uint8_t* row)>;

/// Encodes a PNG file of an image like `image`, whose own rows are ignored, from rows that are asked
/// for once each, from the top: the whole picture never lies in memory. Empty where memory ran out.
///
/// ISA-L's level 1, CPU time of one core: 800 to 950 M voxels/s of RGBA slices, where libdeflate's
/// lowest level makes 80 (it enters every byte of a run into its table), and files 1.15 to 1.25
/// times as large. Rows go without a filter: with the one for repeated rows files of dithered slices
/// grow by a fifth, since a pixel is then found in two forms.
std::vector<uint8_t> encode_png_rows(const PngImage& image, const PutRow& put_row);

/// Decodes the rows of a file that one of the above made from an image like `image`, whose own rows
/// are ignored. Empty where the file is anything else, or truncated.
std::vector<uint8_t> decode_png(std::span<const uint8_t> file, const PngImage& image);

}  // namespace openfab::raster
