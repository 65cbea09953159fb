// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pyramids of image files. The print binary links no image library (rule 8): the
// first use of an image starts a helper, `openfab texture IMAGE -o FILE --space SPACE
// [--luminance]`, and later ones map what it left in the cache.

#include <filesystem>
#include <memory>
#include <string>

#include "runtime/base/result.h"
#include "runtime/texture/pyramid.h"

namespace openfab::texture {

/// How an image is read; part of the cache's key.
struct ImageOptions {
    std::string space = "auto";  ///< "auto", "srgb", "linear" or "data"
    bool luminance = false;      ///< one channel of three
};

/// $OPENFAB_CACHE, else $XDG_CACHE_HOME/openfab, else ~/.cache/openfab, else a folder of the user's
/// in the system's temporary folder.
std::filesystem::path cache_folder();

/// Hash of the image's bytes, the options and the version of the file format. Errors: the image
/// cannot be read.
Result<uint64_t> content_key(const std::filesystem::path& image, const ImageOptions& options);

/// Where the pyramid of an image with this key is kept: <cache>/<16 hex digits>.oftx.
std::filesystem::path cache_file(uint64_t key);

/// The helper: `openfab` beside the running program, else $OPENFAB_HELPER, else `openfab` on the
/// PATH. Empty if none.
std::filesystem::path find_helper();

/// The image's pyramid, from the cache or made now. Errors: image missing or not readable as an
/// image (with the reason that OpenImageIO gives), no helper, cache not writable.
Result<std::shared_ptr<const Pyramid>> get_pyramid(const std::filesystem::path& image,
                                                   const ImageOptions& options, int32_t wrap,
                                                   int32_t filter);

}  // namespace openfab::texture
