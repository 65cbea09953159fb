// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A picture as textures have it: by its own profile, else sRGB, in linear light.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/result.h"
#include "tools/color/lab.h"

namespace openfab::color {

class Picture {
  public:
    /// Reads a picture of up to 64 million pixels; errors name the file.
    static Result<Picture> read(const std::filesystem::path& file);

    int width() const { return width_; }
    int height() const { return height_; }
    /// Returns the linear light of a pixel, from the top left; clamped to the picture.
    const Rgb& at(int x, int y) const;

  private:
    Picture() = default;

    int width_ = 0, height_ = 0;
    std::vector<Rgb> pixels_;
};

/// Encodes a PNG of 8 bits in sRGB of linear light, rows from the top.
Result<std::vector<uint8_t>> png_of(int width, int height, const std::vector<Rgb>& pixels);

}  // namespace openfab::color
