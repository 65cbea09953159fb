// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts an image file to a pyramid by OpenImageIO, for `openfab texture`.

#include <filesystem>

#include "base/result.h"
#include "texture/cache.h"

namespace openfab::tools {

/// The supported formats, for messages.
constexpr const char* kStillFormats =
    "PNG, JPEG, TIFF, OpenEXR, Radiance HDR, PNM, BMP, TGA, GIF and WebP";
/// Those whose readers are hardened: slices of volumes, and pictures outside of `openfab texture`.
constexpr const char* kHardenedFormats = "PNG, JPEG, TIFF, OpenEXR, Radiance HDR and PNM";

/// Reads `image` (still_image.h; 8, 16, 32 bits or float; 1 to 4 channels; EXIF orientation is
/// obeyed) and writes `out` (pyramid_file.h). Space "auto" goes by what the file says of its colours
/// (file_color.h); "data" is linear, and so is alpha. Integers are scaled to 0..1. Formats with
/// fragile readers are read in a child process.
/// Errors: unreadable image with OpenImageIO's reason, values that are not finite, too large
/// (pyramid_layout.h, or for the limits), `out` not writable.
Result<void> make_pyramid_file(const std::filesystem::path& image, const std::filesystem::path& out,
                               const texture::ImageOptions& options,
                               const texture::ReadLimits& limits = {});

/// Decodes a picture and writes nothing: what make_pyramid_file says of it. texture::check_picture asks
/// this of a program that links no image library.
Result<void> check_picture_file(const std::filesystem::path& image,
                                const texture::ImageOptions& options,
                                const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
