// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixels of DICOM files, frame by frame.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Fails where the file has fewer bytes of pixels than its frames take; says how many of how many.
Result<void> check_pixels(const DicomImage& image);

/// Reads frames; of a file whose frames are packed, all are unpacked at once, and kept until another
/// file is read.
class DicomPixels {
  public:
    explicit DicomPixels(int64_t memory_bytes) : memory_bytes_(memory_bytes) {}

    /// Fills width * height values, in the order of the file, after slope and intercept. Errors do
    /// not name the file.
    Result<void> read(const DicomSlice& slice, float* out);

  private:
    Result<void> read_plain(const DicomSlice& slice);
    Result<void> unpack(const std::shared_ptr<const DicomImage>& image);

    int64_t memory_bytes_;
    std::vector<char> bytes_;  ///< of a frame, or of all frames of `unpacked_`
    std::shared_ptr<const DicomImage> unpacked_;
};

}  // namespace openfab::tools
