// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pyramids of volumes (ImageTexture3D): found, named and cached like those of pictures
// (texture/cache.h), made by `openfab texture FILE -o OUT --volume`.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "texture/cache.h"

namespace openfab::texture {

/// How a volume is read; part of the cache's key.
struct VolumeOptions {
    ImageOptions image;
    /// The volume's lowest corner and the size of a texel, mm; default: from the file, else 0 and
    /// 1.
    std::optional<std::array<double, 3>> origin_mm;
    std::optional<std::array<double, 3>> spacing_mm;
    std::string field;  ///< the array or grid that is read of a file of several; empty: see there
    std::string unit;  ///< of the file's lengths: mm, cm, m, um or in; empty: what it says, else mm
    double pitch_mm = 0;            ///< of what is resampled; 0: see there
    std::optional<double> outside;  ///< the value where a file has none
    std::optional<double> time;     ///< of a file of several steps, which is read; else the first
    std::string segment;            ///< of a DICOM segmentation, by its label or number
    /// Which frames of DICOM are read, where several lie in one place; by the numbers of the file.
    std::optional<double> echo, detector, energy_window, phase;
};

/// Whether a file is the list of a medium that a hospital hands out, by its name, `DICOMDIR`.
bool is_medium_list(const std::filesystem::path& file);

/// Whether a file is marked as DICOM (PS3.10, 7.1).
bool is_dicom(const std::filesystem::path& file);

/// The file of a folder of slices that says how large and where they are.
inline constexpr const char* kPrintManifest = "manifest.json";

/// Lists the files that make up a volume: the named one, every file of a folder, or every file
/// whose name matches a pattern: `*` matches anything, `#` a digit, `%d` and `%04d` a number. Of a medium
/// with a list, and of a folder that holds only folders in which there is DICOM, it is all files below. Of a
/// print in a folder it is kPrintManifest, first, and its slices, without what else is written beside them. Of a store of
/// Zarr it is the file that describes it.
/// Slices are in the order of their names, with numbers in them compared by value, the first one at
/// the bottom. Fails where there is none.
Result<std::vector<std::filesystem::path>> volume_files(const std::filesystem::path& source);

/// Lists the data files that `file` names if it is the header of a detached NRRD, NIfTI or MetaImage, or an
/// XDMF file, or the metadata of a store of Zarr; of steps, series and levels, those of the one that the options choose.
std::vector<std::filesystem::path> detached_data(const std::filesystem::path& file,
                                                 const VolumeOptions& options);

/// Hashes all bytes of the files, of its data files, the options and the version of the file
/// format.
Result<uint64_t> volume_key(const std::filesystem::path& source, const VolumeOptions& options,
                            const ReadLimits& limits = {});

/// Same as get_pyramid, for a volume.
Result<std::shared_ptr<const Pyramid>> get_volume(const std::filesystem::path& source,
                                                  const VolumeOptions& options, WrapModes wrap,
                                                  int32_t filter, const ReadLimits& limits = {});

}  // namespace openfab::texture
