// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures in linear light: area resampling from cells of any shape to square pixels, and the way
// to an sRGB PNG.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/result.h"

namespace openfab::preview {

/// A cell of the source, or a pixel: colour and height are means over the covered area.
struct Pixel {
    float color[3]{};  ///< linear
    float height_mm = 0;
    float coverage = 0;  ///< 0 … 1
};

struct Picture {
    int32_t width = 0;
    int32_t height = 0;
    double pixel_mm = 0;
    std::vector<Pixel> pixels;  ///< top row first

    size_t index(int32_t x, int32_t y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
    }
    Pixel& at(int32_t x, int32_t y) { return pixels[index(x, y)]; }
    const Pixel& at(int32_t x, int32_t y) const { return pixels[index(x, y)]; }
};

/// Resamples cells of cell_mm[0] x cell_mm[1], row 0 on top, to square pixels as wide as the finer
/// side of a cell, or a multiple of it that keeps within 2000 pixels a side and 2 million in all.
/// Each pixel is the mean over its area.
Picture resample(int32_t width, int32_t height, const std::array<double, 2>& cell_mm,
                 const std::function<Pixel(int32_t x, int32_t y)>& cell);

/// Takes a picture that is finished.
using TakePicture = std::function<Result<void>(const Picture& picture)>;

/// Returns RGBA of 8 bits each, sRGB; alpha is the coverage.
std::vector<uint8_t> to_rgba8(const Picture& picture);

/// Encodes RGBA, sRGB; alpha is the coverage. Returns an empty file where memory ran out.
std::vector<uint8_t> to_png(const Picture& picture);

}  // namespace openfab::preview
