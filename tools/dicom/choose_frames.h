// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which frames of a series make one volume: those of one time, segment, echo, detector, energy window.

#include <string>
#include <vector>

#include "base/result.h"
#include "texture/volume.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Returns the slices that the options choose. Of a segmentation, frames of other segments stay as empty
/// planes, since what a segment leaves out is known to be none of it. Fails where slices are of several
/// volumes, with what tells them apart and the key that chooses, or where a key chooses nothing.
Result<std::vector<DicomSlice>> choose_frames(std::vector<DicomSlice> slices,
                                              const texture::VolumeOptions& options);

/// Whether a text is the name of a segment in the slices' files.
bool names_segment(const std::vector<DicomSlice>& slices, const std::string& text);

}  // namespace openfab::tools
