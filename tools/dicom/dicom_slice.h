// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One DICOM file: where its pixels lie, and their values. The only files that use GDCM.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

struct DicomSlice {
    std::filesystem::path file;
    std::string series;         ///< its identifier, to tell series apart; never shown
    int64_t series_number = 0;  ///< shown
    int32_t width = 0, height = 0;
    Vec3d position;           ///< of the first pixel's centre, mm
    Vec3d across, down;       ///< to the next column, to the next row, mm
    double thickness_mm = 0;  ///< 0: not given
    double slope = 1, intercept = 0;
    int32_t bits_allocated = 16, bits_stored = 16, high_bit = 15;
    bool has_sign = false;
    bool packed = false;  ///< JPEG, RLE and the like
};

/// Turns GDCM's messages off.
void silence_dicom();

/// Reads what stands before the pixels. Errors do not name the file.
Result<DicomSlice> read_dicom_slice(const std::filesystem::path& file, int64_t memory_bytes);

/// Reads the pixels, in the order of the file: width * height values after slope and intercept.
Result<void> read_dicom_pixels(const DicomSlice& slice, float* out);

}  // namespace openfab::tools
