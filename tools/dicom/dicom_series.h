// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from series of DICOM slices, by GDCM. Of a file only its pixels and what places them are
// looked at: nothing about a person is printed or kept.

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens the slices of one series, one frame a file, in the order of their positions. Values are what
/// the files' slope and intercept make of stored ones: Hounsfield units of CT. Texels lie in the
/// patient's coordinates, in mm, x to the left, y to the back, z to the head; a series that is not
/// along these axes is resampled (placed_grid.h), and needs `outside`. Where a folder has several
/// series, `field` is the number of one. Files named DICOMDIR are left out. Errors name the slice: no
/// DICOM, another size, orientation or spacing than the others, a position twice, a gap.
MadeReader open_dicom_series(const std::vector<std::filesystem::path>& files,
                             const texture::VolumeOptions& options,
                             const texture::ReadLimits& limits);

/// Same as make_volume_file (tools/texture/convert_volume.h), for a folder, pattern or file of slices.
Result<void> make_dicom_volume_file(const std::filesystem::path& source,
                                    const std::filesystem::path& out,
                                    const texture::VolumeOptions& options,
                                    const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
