// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A slice as one grey picture: the fraction of one material, white where a voxel is all of it, for
// printers with masks of light or drops of several sizes.

#include <cstdint>
#include <span>
#include <vector>

#include "backends/raster/slice_files.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Returns whether the pictures are grey, and have 16 bits a pixel, or are TIFF files.
bool is_grey(SliceFormat format);
bool is_grey_of_16_bits(SliceFormat format);
bool is_tiff(SliceFormat format);

/// Encodes fractions, 0 to 1, of all voxels of a slice, the lowest y first: floor(f m + 0.5) of m = 255 or
/// 65535. A TIFF has its resolution and is compressed by Deflate. Empty where memory ran out.
std::vector<uint8_t> encode_grey(std::span<const float> fractions, const pipeline::PrintInfo& info,
                                 const FolderOptions& options);

/// Encodes codes: all or nothing of the material.
std::vector<uint8_t> encode_grey_slice(const pipeline::SliceView& slice,
                                       const pipeline::PrintInfo& info,
                                       const FolderOptions& options);

/// Returns the index of the material that `options` names, or -1; an empty name is that of the first.
int32_t grey_material(const pipeline::PrintInfo& info, const FolderOptions& options);

}  // namespace openfab::raster
