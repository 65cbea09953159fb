// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes from series of DICOM slices, by GDCM. Of a file only its pixels and what places them are
// looked at, and how people name the series: nothing about a person is printed or kept.

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Opens the slices of one series, in the order of their positions; a file of several frames has so many.
/// Values are what the files' slope and intercept make of stored ones: Hounsfield units of CT. Texels lie
/// in the patient's coordinates, in mm, x to the left, y to the back, z to the head; a series that is not
/// along these axes is resampled (placed_grid.h), and needs `outside`. Of several series `field` names
/// one (series_list.h). Files that are no DICOM, or belong to other series and are not read, are passed
/// over and told (guarded.h). Errors name the slice: a position twice, a gap, pixels cut short.
MadeReader open_dicom_series(const std::vector<std::filesystem::path>& files,
                             const texture::VolumeOptions& options,
                             const texture::ReadLimits& limits);

/// Same as make_volume_file (tools/texture/convert_volume.h), for a folder, pattern or file of slices.
Result<void> make_dicom_volume_file(const std::filesystem::path& source,
                                    const std::filesystem::path& out,
                                    const texture::VolumeOptions& options,
                                    const texture::ReadLimits& limits = {});

}  // namespace openfab::tools
