// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Prints as volumes: the codes of their voxels, or the fractions of one material, at their place.

#include <filesystem>
#include <string_view>

#include "texture/cache.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Whether a file that begins so is a print: an .ofr file or a GCVF.
bool is_print(const std::filesystem::path& file, std::string_view begin);

/// Opens an .ofr file, a GCVF or a folder of slices that are all there. Of grey slices the values are the
/// fractions of their material, 0..1; else they are codes, 0 void, 1 the first material. Rows rise in y,
/// and the slices that the print has are at their place in build space.
MadeReader open_print(const std::filesystem::path& path, const texture::ReadLimits& limits);

}  // namespace openfab::tools
