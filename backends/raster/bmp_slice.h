// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A slice as one BMP file of one bit a voxel for each material, as print heads are driven: black, bit
// 1, where a drop of the material falls. BITMAPINFOHEADER, uncompressed, the lowest y first in the
// file as the format wants it, rows padded to four bytes.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Encodes the files of a slice, one after the other in order of the materials; all have
/// bmp_file_bytes. `flip_x`: +x points left.
std::vector<uint8_t> encode_bmp_slice(const pipeline::SliceView& slice,
                                      const pipeline::PrintInfo& info, bool flip_x);

/// Returns the size of the file of one material.
size_t bmp_file_bytes(const pipeline::PrintInfo& info);

/// Decodes the codes of a slice from its files, one a byte, lowest y first, x as in the picture;
/// empty where encode_bmp_slice would not write the files for this print.
std::vector<uint8_t> decode_bmp_slice(std::span<const uint8_t> files,
                                      const pipeline::PrintInfo& info);

}  // namespace openfab::raster
