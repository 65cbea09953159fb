// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backends/common/format.h"

#include "backends/raster/slice_files.h"

namespace openfab::raster {

/// Returns the options of a folder in one of the grey formats.
FolderOptions grey_folder_options(const backends::Format& format, bool flip_x,
                                  const std::string& material);

extern const backends::Format kPngFormat;  ///< a folder of PNG slices
extern const backends::Format
    kBmpFormat;  ///< a folder of bitmaps, one for each material of a slice
/// Folders of grey pictures of one material's fraction, of 8 or 16 bits, PNG or TIFF.
extern const backends::Format kGreyFormat, kGrey16Format, kTiffFormat, kTiff16Format;
extern const backends::Format kNpyFormat;  ///< an array of codes for numpy

}  // namespace openfab::raster
