// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a DICOM file says of its pixels' form and of its parts.

#include <gdcmDataSet.h>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Reads the kind of object, and of a segmentation its segments.
Result<void> read_kind(const gdcm::DataSet& set, DicomImage* out);

/// Reads size, bits and the number of frames; `sample` says whether they are numbers with a fraction.
Result<void> read_format(const gdcm::DataSet& set, DicomImage* out);

}  // namespace openfab::tools
