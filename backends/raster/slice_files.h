// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The files of one slice: their names and bytes, in each of the formats that fill a folder.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

enum class SliceFormat : uint8_t {
    kRgba,     ///< a PNG; void has alpha 0, a material its key colour
    kIndexed,  ///< a PNG with a palette of the key colours
    kGrey8,    ///< a PNG of one material's fraction, 8 bits a voxel
    kGrey16,   ///< the same of 16 bits
    kTiff8,    ///< a TIFF of one material's fraction, 8 bits a voxel
    kTiff16,   ///< the same of 16 bits
    kBitmaps,  ///< a BMP of one bit a voxel for each material, bit 1 where it is
};

struct FolderOptions {
    SliceFormat format = SliceFormat::kRgba;
    bool flip_x = false;        ///< +x points left, for front ends that mirror
    std::string grey_material;  ///< the one of grey pictures; empty: the first
    bool front_end_makes_support = true;
    std::string handoff;  ///< the printer's own lines for HANDOFF.txt
};

/// Returns the number of files of a slice: 1, or the number of materials.
size_t files_a_slice(const pipeline::PrintInfo& info, const FolderOptions& options);

/// Returns `slice_0001.png`, or `slice_0001_2.bmp` for the second material (`file` 1). The numbers
/// of slices have as many digits as the whole grid needs, four at least.
std::string slice_file_name(int32_t z, size_t file, const pipeline::PrintInfo& info,
                            const FolderOptions& options);

/// Returns whether slice_file_name returns such names, or an interrupted write leaves them.
bool is_slice_name(const std::string& name);

/// Encodes the files of one slice, one after the other, all of the same size. Empty where memory ran
/// out.
std::vector<uint8_t> encode_slice(const pipeline::SliceView& slice, const pipeline::PrintInfo& info,
                                  const FolderOptions& options);

/// Decodes the packed rows of a slice from its files; empty where encode_slice would not write them
/// for this print, or where they are truncated.
std::vector<uint8_t> decode_slice(std::span<const uint8_t> files, const pipeline::PrintInfo& info,
                                  const FolderOptions& options);

}  // namespace openfab::raster
