// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// VTKHDF, https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/: VTK's grids in HDF5, of which image data
// are read.

#include <filesystem>

#include "texture/cache.h"
#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens image data: the field that the options name, of points or cells, by origin, spacing and direction, as of a
/// `.vti`. Fails where the file holds another kind of grid, or several steps in time.
MadeReader open_vtk_hdf(const std::filesystem::path& file, const texture::VolumeOptions& options,
                        const texture::ReadLimits& limits);

}  // namespace openfab::tools
