// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/height_map.h"

#include <algorithm>
#include <bit>

#include "backends/gcvf/solid_bits.h"
#include "backends/raster/png_encode.h"

namespace openfab::gcvf {

HeightMap::HeightMap(int32_t width, int32_t height)
    : width_(width),
      height_(height),
      tops_(solid_row_bytes(width) * 8 * static_cast<size_t>(height)) {}

void HeightMap::add(uint16_t z, std::span<const uint8_t> solid) {
    for (size_t i = 0; i < solid.size(); ++i) {
        uint16_t* const tops = tops_.data() + 8 * i;
        if (solid[i] == 0xff) {
            std::fill_n(tops, 8, z);
            continue;
        }
        for (unsigned bits = solid[i]; bits != 0; bits &= bits - 1)
            tops[std::countr_zero(bits)] = z;
    }
}

std::vector<uint8_t> HeightMap::png(bool flip_x) const {
    raster::PngImage image;
    image.width = width_;
    image.height = height_;
    image.color = raster::PngColor::kGrey;
    image.bits = 16;
    const size_t stride = solid_row_bytes(width_) * 8;
    return raster::encode_png_rows(image, [&](int32_t y, uint8_t* row) {
        const uint16_t* const tops = tops_.data() + stride * static_cast<size_t>(height_ - 1 - y);
        for (int32_t x = 0; x < width_; ++x, row += 2) {
            const uint16_t top = tops[flip_x ? width_ - 1 - x : x];
            row[0] = static_cast<uint8_t>(top >> 8);
            row[1] = static_cast<uint8_t>(top);
        }
    });
}

}  // namespace openfab::gcvf
