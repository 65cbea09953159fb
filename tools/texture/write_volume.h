// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes the pyramid of a volume whose reader is open: the last step of every converter of volumes.

#include <filesystem>
#include <functional>

#include "base/result.h"
#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens `source` by `open` and writes `out` (pyramid_file.h). The options' origin and spacing win
/// over the reader's. Errors: those of `open` and of the reader, with the file named; values that
/// are not finite; too large (pyramid_layout.h, or for the limits); `out` not writable. What a
/// library throws is an error, too. Unless `has_frames`, options that choose frames of DICOM are refused.
Result<void> write_volume(const std::filesystem::path& source, const std::filesystem::path& out,
                          const texture::VolumeOptions& options, const texture::ReadLimits& limits,
                          const std::function<MadeReader()>& open, bool has_frames = false);

}  // namespace openfab::tools
