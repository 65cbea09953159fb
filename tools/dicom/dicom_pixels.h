// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pixels of DICOM files, frame by frame.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Fails where the file has fewer bytes of pixels than its frames take; says how many of how many. Finds
/// the items of packed ones.
Result<void> check_pixels(DicomImage* image);

/// Reads frames; a deflated file is unpacked at once, and kept until another one is read.
class DicomPixels {
  public:
    explicit DicomPixels(int64_t memory_bytes) : memory_bytes_(memory_bytes) {}

    /// Fills width * height values, in the order of the file, after slope and intercept; NaN where a
    /// stored number stands for nothing. Errors do not name the file.
    Result<void> read(const DicomSlice& slice, float* out);

    /// Whether a number that was read so far has more digits than a float keeps.
    bool has_rounded() const { return has_rounded_; }

  private:
    /// Where a frame's first pixel lies among bytes.
    struct Frame {
        std::string_view bytes;
        int64_t first_bit = 0;  ///< of pixels of 1 bit
    };

    Result<Frame> read_plain(const DicomSlice& slice);
    Result<Frame> read_deflated(const DicomSlice& slice);
    Result<Frame> read_packed(const DicomSlice& slice);
    Result<void> decode(const DicomImage& image, const std::string& packed);
    void convert(const DicomSlice& slice, const Frame& frame, float* out);

    int64_t memory_bytes_;
    std::string bytes_;  ///< of a frame, or of all of `inflated_`
    std::shared_ptr<const DicomImage> inflated_;
    bool has_rounded_ = false;
};

}  // namespace openfab::tools
