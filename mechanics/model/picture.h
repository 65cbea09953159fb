// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small pictures: lines, discs, numbers.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace openfab::mechanics {

using Colour = std::array<uint8_t, 3>;

class Picture {
  public:
    Picture(int32_t width, int32_t height, Colour background = {255, 255, 255});
    void put(int32_t x, int32_t y, Colour colour);
    void line(double x0, double y0, double x1, double y1, Colour colour, double width = 1);
    void circle(double x, double y, double radius, Colour colour);
    /// Text of digits, letters and `.-=/%()`, seven pixels high times `size`; (x, y) is its upper left corner.
    void text(int32_t x, int32_t y, const std::string& text, Colour colour, int32_t size = 2);
    int32_t width() const { return width_; }
    int32_t height() const { return height_; }
    std::vector<uint8_t> png() const;

  private:
    int32_t width_, height_;
    std::vector<uint8_t> rows_;  ///< with filter bytes
};

/// A colour of 0 ... 1, dark blue over green to yellow, in order of lightness.
Colour scale_colour(double t);

}  // namespace openfab::mechanics
