// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a file's frames lie, what their stored numbers stand for, and of what they are.

#include <gdcmDataSet.h>

#include <memory>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Reads the frames of a file. A frame has the position that it states itself, or that all of them state;
/// without functional groups those of one file follow each other in space where the file says so.
Result<std::vector<DicomSlice>> read_frames(const gdcm::DataSet& set,
                                            const std::shared_ptr<DicomImage>& image);

}  // namespace openfab::tools
