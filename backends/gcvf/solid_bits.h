// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which voxels of a slice are of a material: a bit each, so that what is left to do in order of the
// slices reads little.

#include <cstdint>
#include <span>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::gcvf {

/// Returns the bytes of a row: voxel x is bit x % 8 of byte x / 8, and the bits beyond the row are 0.
inline size_t solid_row_bytes(int32_t width) {
    return (static_cast<size_t>(width) + 7) / 8;
}

/// Writes the bits of a slice, lowest y first; `out` has slice.height rows.
void put_solid_bits(const pipeline::SliceView& slice, int32_t bits, std::span<uint8_t> out);

}  // namespace openfab::gcvf
