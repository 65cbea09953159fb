// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts an image file to a pyramid by OpenImageIO, for `openfab texture`.

#include <filesystem>

#include "base/result.h"
#include "texture/cache.h"

namespace openfab::tools {

/// The supported formats, for messages.
constexpr const char* kStillFormats = "PNG, JPEG, TIFF, OpenEXR, Radiance HDR and PNM";

/// Reads `image` (still_image.h; 8, 16, 32 bits or float; 1 to 4 channels; EXIF orientation is
/// obeyed) and writes `out` (pyramid_file.h). Space "auto" treats 8-bit pictures as sRGB and others
/// as linear; "data" is linear, too, and so is alpha. Integers are scaled to 0..1.
/// Errors: unreadable image with OpenImageIO's reason, values that are not finite, too large
/// (pyramid_layout.h, or for the limits), `out` not writable.
Result<void> make_pyramid_file(const std::filesystem::path& image, const std::filesystem::path& out,
                               const texture::ImageOptions& options,
                               const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
