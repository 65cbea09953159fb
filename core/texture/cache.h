// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pyramids of image files. The print binary links no image library (rule 8): the first use of an
// image starts a helper, `openfab texture IMAGE -o FILE --space SPACE [--luminance] [--opaque]`, and later
// uses map the file that it wrote to the cache.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "texture/pyramid.h"

namespace openfab::texture {

/// How an image is read; part of the cache's key.
struct ImageOptions {
    std::string space = "auto";  ///< "auto", "srgb", "linear" or "data"
    bool luminance = false;      ///< one channel of three
    bool opaque = false;         ///< without its alpha
};

/// Limits for converting an image to a pyramid.
struct ReadLimits {
    /// Pyramids that take more memory are refused, and so are files that take more to decode.
    int64_t memory_bytes = kDefaultMemoryBytes;
    /// Folders below which a file may name others (base/input_file.h); empty: its own.
    std::vector<std::filesystem::path> roots;
};

/// Returns $OPENFAB_CACHE, else $XDG_CACHE_HOME/openfab, else ~/.cache/openfab, or its subfolder
/// `part`, created where it is missing. Fails where the folder cannot be trusted (own_folder);
/// callers then work without a cache.
Result<std::filesystem::path> cache_folder(const std::string& part = {});

/// From now on, converted pictures and scans are neither taken from the cache nor put there: each process makes
/// its own, in a temporary folder which goes with it. So it is from the start where OPENFAB_NO_CACHE is set.
void keep_no_textures();
bool keeps_textures();

/// Fails where nothing can be kept in what cache_folder has returned: it failed, or the folder can only be
/// read. Callers then say so, once, and make what they need in a temporary folder.
Result<void> check_keeps(const Result<std::filesystem::path>& folder);

/// Hashes the image's bytes, the options and the version of the file format. Fails where the image
/// cannot be read.
Result<uint64_t> content_key(const std::filesystem::path& image, const ImageOptions& options);

/// Returns the file name in the cache of the pyramid with this key: 16 hex digits and .oftx.
std::string cache_name(uint64_t key);

/// Names the program that converts, `openfab-texture`, for a process that is none of ours and has it
/// elsewhere; it comes before what find_helper finds. Before the first picture is read.
void set_converter(std::filesystem::path program);

/// Finds the helper: `openfab` beside the running program, else $OPENFAB_HELPER, else `openfab` in
/// an absolute folder of the PATH. Empty if none.
std::filesystem::path find_helper();

/// Says whether a picture can be read, by decoding it: for who writes a world, such as `openfab import`,
/// before a print. Starts the helper with `--check`, says its notes; keeps nothing. Errors are those of get_pyramid.
Result<void> check_picture(const std::filesystem::path& image, const ImageOptions& options = {},
                           const ReadLimits& limits = {});

/// Returns the image's pyramid, from the cache or converted now. Damaged cache files are
/// regenerated. Errors: image missing or not readable as an image (with OpenImageIO's reason), too
/// large for the limits, no helper, disk full. The caller says its notes (Pyramid::notes).
Result<std::shared_ptr<const Pyramid>> get_pyramid(const std::filesystem::path& image,
                                                   const ImageOptions& options, WrapModes wrap,
                                                   int32_t filter, const ReadLimits& limits = {});

}  // namespace openfab::texture
