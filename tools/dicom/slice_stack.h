// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slices in the order of their places, at equal distances.

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"
#include "tools/texture/placed_grid.h"

namespace openfab::tools {

/// A plane of the volume.
struct StackPlane {
    int32_t below = -1;  ///< the slice that lies there, or below; -1: nothing does, it is 0
    double share = 0;    ///< of the next slice
};

struct SliceStack {
    std::vector<DicomSlice> slices;  ///< from the lowest along their normal
    std::vector<StackPlane> planes;
    GridFrame frame;
};

/// Orders slices. A gap, a place that is taken twice, or one beside the line of the others is an error
/// that names the slice. Planes that a segmentation leaves out are empty; doses in planes at several
/// distances get the planes between them.
Result<SliceStack> stack_slices(std::vector<DicomSlice> slices);

}  // namespace openfab::tools
