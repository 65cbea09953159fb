// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backends/common/format.h"

namespace openfab::raster {

extern const backends::Format kPngFormat;  ///< a folder of PNG slices
extern const backends::Format
    kBmpFormat;  ///< a folder of bitmaps, one for each material of a slice
extern const backends::Format kNpyFormat;  ///< an array of codes for numpy

}  // namespace openfab::raster
