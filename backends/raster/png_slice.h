// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A slice as one PNG: void has alpha 0, a material its key colour.

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Encodes a slice; `indexed`: by a palette of the key colours instead of RGBA; `flip_x`: +x points
/// left. Empty where memory ran out.
std::vector<uint8_t> encode_png_slice(const pipeline::SliceView& slice,
                                      const pipeline::PrintInfo& info, bool indexed, bool flip_x);

/// Decodes the codes of a slice, one a byte, lowest y first, x as in the picture; empty where
/// encode_png_slice would not write the file for this print, or where it is truncated.
std::vector<uint8_t> decode_png_slice(std::span<const uint8_t> file,
                                      const pipeline::PrintInfo& info, bool indexed);

/// Returns whether two materials, or a material and void, have one colour in RGBA slices.
bool shares_a_color(const pipeline::PrintInfo& info);

}  // namespace openfab::raster
