// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Readers of what programs for scans write: NIfTI, MetaImage and MRC. Numbers are taken as they are, times the
// file's slope and plus its intercept; axes may be turned (placed_grid.h).

#include <filesystem>
#include <string_view>

#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Returns whether a file is NIfTI, packed by gzip or not, by its first bytes.
bool is_nifti_file(const std::filesystem::path& file);
/// Opens NIfTI-1 or -2, in one file or as header and numbers: of several volumes in time the one whose
/// number, from 0, is the options' field.
MadeReader open_nifti(const std::filesystem::path& file, const texture::VolumeOptions& options,
                      const texture::ReadLimits& limits);
/// Opens a MetaImage of three dimensions.
MadeReader open_meta(const std::filesystem::path& file, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits);

/// Returns whether a file that begins so is MRC: a map of a microscope.
bool is_mrc(std::string_view head);
/// Opens MRC; its lengths are in Angstrom, unless the options name a unit.
MadeReader open_mrc(const std::filesystem::path& file, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits);

}  // namespace openfab::tools
