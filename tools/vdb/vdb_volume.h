// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from grids of OpenVDB files.

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens a grid of float, double, int32 or int64 numbers, or of vectors of three floats or doubles:
/// the one that `field` names, else the only one. The volume is the box of its active voxels, in place
/// by its transform, which must be linear; where that is turned it is resampled (placed_grid.h).
/// Voxels that are not active have what the file gives them, its background mostly, or `outside`.
/// Lengths are in the unit that the file's metadata names, else mm.
MadeReader open_vdb_grid(const std::filesystem::path& file, const texture::VolumeOptions& options,
                         const texture::ReadLimits& limits);

/// Same as make_volume_file (tools/texture/convert_volume.h), for an OpenVDB file.
Result<void> make_vdb_volume_file(const std::filesystem::path& source,
                                  const std::filesystem::path& out,
                                  const texture::VolumeOptions& options,
                                  const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
