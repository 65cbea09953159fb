// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera's file says of its colours in EXIF (JPEG, PNG, TIFF), and how many components a JPEG has;
// OpenImageIO does not say either.

#include <string_view>

#include "base/input_file.h"

namespace openfab::tools {

/// Colours of a file without a profile, by the design rule for camera files (DCF 2.0).
enum class ExifColors {
    kUnsaid,        ///< or sRGB
    kAdobeRgb,      ///< uncalibrated, and of interoperability R03
    kUncalibrated,  ///< others than sRGB
};

/// `format` is OpenImageIO's name of it. A file that is damaged says nothing.
ExifColors exif_colors(const InputFile& file, std::string_view format);

/// Returns the components of a JPEG's frame, 4 for inks; 0 where it has none.
int jpeg_components(const InputFile& file);

}  // namespace openfab::tools
