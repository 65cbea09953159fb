// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pyramids of image files. The print binary links no image library (rule 8): the
// first use of an image starts a helper, `openfab texture IMAGE -o FILE --space SPACE
// [--luminance]`, and later ones map what it left in the cache.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "texture/pyramid.h"

namespace openfab::texture {

/// How an image is read; part of the cache's key.
struct ImageOptions {
    std::string space = "auto";  ///< "auto", "srgb", "linear" or "data"
    bool luminance = false;      ///< one channel of three
};

constexpr int64_t kDefaultMemory = 1'500'000'000;

/// What may be used and read to make a pyramid.
struct ReadLimits {
    /// A pyramid that takes more is refused, and so is a file that takes more to decode.
    int64_t memory_bytes = kDefaultMemory;
    /// Folders below which a file may name others (base/input_file.h); none: below its own.
    std::vector<std::filesystem::path> roots;
};

/// $OPENFAB_CACHE, else $XDG_CACHE_HOME/openfab, else ~/.cache/openfab, or a folder in it, made
/// where it is missing. Nothing else is trusted: the error says why there is none (own_folder), and
/// whoever wants one goes without.
Result<std::filesystem::path> cache_folder(const std::string& part = {});

/// Hash of the image's bytes, the options and the version of the file format. Errors: the image
/// cannot be read.
Result<uint64_t> content_key(const std::filesystem::path& image, const ImageOptions& options);

/// The name of the pyramid of an image with this key in the cache: 16 hex digits, and .oftx.
std::string cache_name(uint64_t key);

/// The helper: `openfab` beside the running program, else $OPENFAB_HELPER, else `openfab` in an
/// absolute folder of the PATH. Empty if none.
std::filesystem::path find_helper();

/// The image's pyramid, from the cache or made now. What is damaged in the cache is made again.
/// Errors: image missing or not readable as an image (with the reason that OpenImageIO gives), too
/// large for the limits, no helper, disk full.
Result<std::shared_ptr<const Pyramid>> get_pyramid(const std::filesystem::path& image,
                                                   const ImageOptions& options, int32_t wrap,
                                                   int32_t filter, const ReadLimits& limits = {});

}  // namespace openfab::texture
