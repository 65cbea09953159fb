// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which array of a store of Zarr is read as a volume, and where it lies: of OME-Zarr (NGFF 0.1 to 0.5, https://ngff.openmicroscopy.org)
// by its multiscales, of others by the order of its axes.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "texture/volume.h"
#include "texture/zarr_array.h"

namespace openfab::texture {

struct ZarrVolume {
    ZarrArray array;
    std::string
        path;  ///< the array's folder from the store's on, with a slash behind it; empty: the store is the array
    /// Which axis of the array is x, y and z, and which holds channels; others have one place.
    std::array<size_t, 3> axes{};
    std::optional<size_t> channels;
    /// The size of a texel, and its lowest corner where the file has one, mm.
    std::optional<std::array<double, 3>> spacing, origin;
    bool labels = false;      ///< its numbers are names, not measurements
    bool print = false;       ///< by OpenFab; level 0, all of it, is that of its list of shards
    bool unit_given = false;  ///< of its lengths
    bool lengths = false;     ///< it says how large a texel is
    std::vector<double>
        levels_mm;     ///< the longest side of a texel of each level; empty without levels
    size_t level = 0;  ///< which of them is read
    std::vector<std::string> metadata;  ///< the files that were read, from the store's folder on

    /// Counts texels along x, y and z, and channels.
    std::array<int64_t, 4> sides() const;
};

/// Returns the file by which a folder is a store, or an array or a group of one; empty for other folders.
std::filesystem::path zarr_metadata(const std::filesystem::path& folder);
/// Returns whether a file is one of those, by its name.
bool is_zarr_metadata(const std::filesystem::path& file);

/// Reads which volume the options choose: `field` by the path of an array or group in the store, `pitch_mm` the coarsest level
/// whose texels are no longer. `file` is as returned by zarr_metadata. Errors do not name the store.
Result<ZarrVolume> read_zarr_store(const std::filesystem::path& file, const VolumeOptions& options,
                                   const ReadLimits& limits);

/// Lists the files of metadata and those of chunks that are there, from the store's folder on. Fails where the array has too
/// many.
Result<std::vector<std::string>> zarr_files(const std::filesystem::path& file,
                                            const ZarrVolume& volume);

/// Counts the files along each axis that hold part of the volume. Fails where there are more than a million.
Result<std::vector<int64_t>> zarr_file_counts(const ZarrVolume& volume);
/// Goes on to the next place of so many along each axis, the last fastest; false at the end.
bool next_place(const std::vector<int64_t>& counts, std::vector<int64_t>* at);

}  // namespace openfab::texture
