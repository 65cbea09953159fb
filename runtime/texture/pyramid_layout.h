// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the levels of a pyramid lie, and the filter that makes them. One implementation for the
// file maker and for pyramids in memory, so that both give the same bits.

#include <cstdint>
#include <vector>

#include "runtime/base/result.h"

namespace openfab::texture {

struct PyramidLayout {
    struct Level {
        int64_t texels = 0;  ///< offset of the level in floats
        int32_t width = 0;
        int32_t height = 0;
        int64_t minmax = 0;  ///< offset in the min-max floats: twice `texels`
    };
    int32_t channels = 0;
    std::vector<Level> levels;
    int64_t texel_floats = 0;
    int64_t minmax_floats = 0;
};

/// Fails for sizes that are not positive, for other than 1 to 4 channels, for a side above 16384,
/// and where the min-max floats no longer have 31-bit offsets (16384 x 16384 with 4 channels).
Result<PyramidLayout> pyramid_layout(int32_t width, int32_t height, int32_t channels);

/// Level 0 of `texels` is given; makes the levels above it, and all of `minmax`. Texel i of a level
/// covers the interval [i n / m, (i + 1) n / m) of the n texels below for its own m, so that means
/// are kept for odd sizes too; its min-max covers every texel that it touches.
void fill_pyramid(const PyramidLayout& layout, float* texels, float* minmax);

/// The int32 block that kernels read (pyramid.h).
std::vector<int32_t> pyramid_info(const PyramidLayout& layout, int32_t wrap, int32_t filter);

}  // namespace openfab::texture
