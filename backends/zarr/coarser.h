// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A level of half the resolution: a voxel has the code that most of the 2 x 2 x 2 below it have, of several as
// frequent ones the lowest. Where the grid ends within the eight, those that are there count.

#include <array>
#include <cstdint>

namespace openfab::zarr {

/// Makes a row of (width + 1) / 2 codes of four rows of `width`: two of a slice, two of the next. Where there is no
/// next row or slice, the same one is given twice.
void halve_rows(const std::array<const uint8_t*, 4>& rows, int32_t width, uint8_t* out);

/// Returns the index of the second of a pair that begins with `2 * i`, of `count`.
inline int32_t second_of_pair(int32_t i, int32_t count) {
    return 2 * i + 1 < count ? 2 * i + 1 : 2 * i;
}

}  // namespace openfab::zarr
