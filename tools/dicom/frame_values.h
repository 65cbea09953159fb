// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the stored numbers of a frame stand for.

#include <gdcmDataSet.h>

#include "base/result.h"
#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Reads slope and intercept of frames: the rescale, of a dose its scale, of a parametric map its Real
/// World Value Mapping (PS3.3, C.7.6.16.2.11), which is all that gives it a meaning, of a fraction of
/// a segment the highest one (C.8.20.2.3). Labels and bits are what they are.
class FrameValues {
  public:
    FrameValues(const gdcm::DataSet& set, const FrameGroups& groups, DicomImage* image);
    Result<void> read(int32_t frame, DicomSlice* out);

  private:
    Result<void> read_rescale(int32_t frame, DicomSlice* out) const;
    Result<void> read_mapping(int32_t frame, DicomSlice* out) const;
    Result<void> read_fraction(DicomSlice* out) const;

    const gdcm::DataSet& set_;
    const FrameGroups& groups_;
    DicomImage* image_;
};

}  // namespace openfab::tools
