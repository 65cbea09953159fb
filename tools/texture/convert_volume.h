// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts a stack of slices, an NRRD, NPY or .cube file to a pyramid, for `openfab texture
// --volume`.

#include <filesystem>

#include "base/result.h"
#include "texture/volume.h"

namespace openfab::tools {

/// Reads `source` (texture::volume_files, volume_reader.h) and writes `out` (pyramid_file.h).
/// Errors: see make_pyramid_file.
Result<void> make_volume_file(const std::filesystem::path& source, const std::filesystem::path& out,
                              const texture::VolumeOptions& options,
                              const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
