// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a DICOM file says before its pixels: of which series it is, and where each of its frames lies.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

/// A file with pixels.
struct DicomImage {
    std::filesystem::path file;
    std::string series;                    ///< its identifier
    std::optional<int64_t> series_number;  ///< as people know it
    std::string description;               ///< of the series; may be empty
    int32_t width = 0, height = 0, frames = 1;
    int32_t bits_allocated = 16, bits_stored = 16, high_bit = 15;
    bool has_sign = false;
    bool is_inverted = false;    ///< its low values are shown white (MONOCHROME1)
    bool is_placed = true;       ///< else its first pixel is put at 0, 0, 0
    bool is_packed = false;      ///< JPEG, RLE and the like
    bool is_deflated = false;    ///< all that follows the first elements
    bool is_big_endian = false;  ///< its pixels are
    bool has_words = true;       ///< pixels of 8 bits, too, lie two in a word
    int64_t pixels_at = 0;       ///< in the file; neither this nor the next where it is deflated
    int64_t pixels_bytes = 0;    ///< as the file says; unknown where they are packed

    int64_t pixel_bytes() const { return bits_allocated / 8; }
    int64_t frame_bytes() const { return pixel_bytes() * width * height; }
};

/// A frame of a file.
struct DicomSlice {
    std::shared_ptr<const DicomImage> image;
    int32_t frame = 0;
    Vec3d position;           ///< of the first pixel's centre, mm
    Vec3d across, down;       ///< to the next column, to the next row, mm
    double thickness_mm = 0;  ///< 0: not given
    double slope = 1, intercept = 0;

    /// Names it for people: `im7`, `im7, frame 3`.
    std::string name() const;
};

struct DicomHead {
    std::filesystem::path file;
    std::string series;              ///< empty where it was not found
    std::vector<std::string> names;  ///< of the series, as a field may say
    /// Empty where the file is none of DICOM, has no pixels or some that are not read.
    std::vector<DicomSlice> slices;
    bool is_foreign = false;       ///< no DICOM, or a list of files
    std::optional<Error> trouble;  ///< why its pixels are not read; without the file's name
};

/// Turns GDCM's messages off.
void silence_dicom();

/// Reads what stands before the pixels. Fails, without the file's name, where the file cannot be
/// opened or takes too much memory.
Result<DicomHead> read_dicom_head(const std::filesystem::path& file, int64_t memory_bytes);

}  // namespace openfab::tools
