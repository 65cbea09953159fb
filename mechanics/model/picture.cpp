// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/picture.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <numbers>

#include "backends/raster/png_encode.h"

namespace openfab::mechanics {

namespace {

/// Five columns of seven bits a character, the lowest bit on top.
struct Glyph {
    char character;
    std::array<uint8_t, 5> columns;
};
constexpr Glyph kGlyphs[] = {
    {'0', {0x3e, 0x51, 0x49, 0x45, 0x3e}}, {'1', {0x00, 0x42, 0x7f, 0x40, 0x00}},
    {'2', {0x42, 0x61, 0x51, 0x49, 0x46}}, {'3', {0x21, 0x41, 0x45, 0x4b, 0x31}},
    {'4', {0x18, 0x14, 0x12, 0x7f, 0x10}}, {'5', {0x27, 0x45, 0x45, 0x45, 0x39}},
    {'6', {0x3c, 0x4a, 0x49, 0x49, 0x30}}, {'7', {0x01, 0x71, 0x09, 0x05, 0x03}},
    {'8', {0x36, 0x49, 0x49, 0x49, 0x36}}, {'9', {0x06, 0x49, 0x49, 0x29, 0x1e}},
    {'.', {0x00, 0x60, 0x60, 0x00, 0x00}}, {'-', {0x08, 0x08, 0x08, 0x08, 0x08}},
    {'+', {0x08, 0x08, 0x3e, 0x08, 0x08}}, {'=', {0x14, 0x14, 0x14, 0x14, 0x14}},
    {'/', {0x20, 0x10, 0x08, 0x04, 0x02}}, {'%', {0x23, 0x13, 0x08, 0x64, 0x62}},
    {'(', {0x00, 0x1c, 0x22, 0x41, 0x00}}, {')', {0x00, 0x41, 0x22, 0x1c, 0x00}},
    {'A', {0x7e, 0x11, 0x11, 0x11, 0x7e}}, {'B', {0x7f, 0x49, 0x49, 0x49, 0x36}},
    {'C', {0x3e, 0x41, 0x41, 0x41, 0x22}}, {'D', {0x7f, 0x41, 0x41, 0x22, 0x1c}},
    {'E', {0x7f, 0x49, 0x49, 0x49, 0x41}}, {'F', {0x7f, 0x09, 0x09, 0x09, 0x01}},
    {'G', {0x3e, 0x41, 0x49, 0x49, 0x7a}}, {'H', {0x7f, 0x08, 0x08, 0x08, 0x7f}},
    {'I', {0x00, 0x41, 0x7f, 0x41, 0x00}}, {'J', {0x20, 0x40, 0x41, 0x3f, 0x01}},
    {'K', {0x7f, 0x08, 0x14, 0x22, 0x41}}, {'L', {0x7f, 0x40, 0x40, 0x40, 0x40}},
    {'M', {0x7f, 0x02, 0x0c, 0x02, 0x7f}}, {'N', {0x7f, 0x04, 0x08, 0x10, 0x7f}},
    {'O', {0x3e, 0x41, 0x41, 0x41, 0x3e}}, {'P', {0x7f, 0x09, 0x09, 0x09, 0x06}},
    {'Q', {0x3e, 0x41, 0x51, 0x21, 0x5e}}, {'R', {0x7f, 0x09, 0x19, 0x29, 0x46}},
    {'S', {0x46, 0x49, 0x49, 0x49, 0x31}}, {'T', {0x01, 0x01, 0x7f, 0x01, 0x01}},
    {'U', {0x3f, 0x40, 0x40, 0x40, 0x3f}}, {'V', {0x1f, 0x20, 0x40, 0x20, 0x1f}},
    {'W', {0x3f, 0x40, 0x38, 0x40, 0x3f}}, {'X', {0x63, 0x14, 0x08, 0x14, 0x63}},
    {'Y', {0x07, 0x08, 0x70, 0x08, 0x07}}, {'Z', {0x61, 0x51, 0x49, 0x45, 0x43}},
};

}  // namespace

Picture::Picture(int32_t width, int32_t height, Colour background)
    : width_(width),
      height_(height),
      rows_(static_cast<size_t>(height) * (3 * static_cast<size_t>(width) + 1)) {
    for (int32_t y = 0; y < height; ++y)
        for (int32_t x = 0; x < width; ++x)
            put(x, y, background);
}

void Picture::put(int32_t x, int32_t y, Colour colour) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    const size_t at = static_cast<size_t>(y) * (3 * static_cast<size_t>(width_) + 1) + 1 +
                      3 * static_cast<size_t>(x);
    std::copy(colour.begin(), colour.end(), rows_.begin() + static_cast<ptrdiff_t>(at));
}

void Picture::line(double x0, double y0, double x1, double y1, Colour colour, double width) {
    const double length = std::hypot(x1 - x0, y1 - y0);
    const int steps = std::max(1, static_cast<int>(2 * length));
    const int around = static_cast<int>(width / 2);
    for (int i = 0; i <= steps; ++i) {
        const double t = static_cast<double>(i) / steps;
        const auto x = static_cast<int32_t>(std::lround(x0 + t * (x1 - x0)));
        const auto y = static_cast<int32_t>(std::lround(y0 + t * (y1 - y0)));
        for (int dy = -around; dy <= around; ++dy)
            for (int dx = -around; dx <= around; ++dx)
                put(x + dx, y + dy, colour);
    }
}

void Picture::circle(double x, double y, double radius, Colour colour) {
    constexpr int kSteps = 720;
    for (int i = 0; i < kSteps; ++i) {
        const double a = 2 * std::numbers::pi * i / kSteps;
        put(static_cast<int32_t>(std::lround(x + radius * std::cos(a))),
            static_cast<int32_t>(std::lround(y + radius * std::sin(a))), colour);
    }
}

void Picture::text(int32_t x, int32_t y, const std::string& text, Colour colour, int32_t size) {
    for (const char c : text) {
        const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        const auto* glyph = std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                                         [&](const Glyph& g) { return g.character == upper; });
        if (glyph != std::end(kGlyphs))
            for (int32_t i = 0; i < 5 * size; ++i)
                for (int32_t j = 0; j < 7 * size; ++j)
                    if (glyph->columns[static_cast<size_t>(i / size)] >> (j / size) & 1)
                        put(x + i, y + j, colour);
        x += 6 * size;
    }
}

std::vector<uint8_t> Picture::png() const {
    raster::PngImage image;
    image.width = width_;
    image.height = height_;
    image.color = raster::PngColor::kRgb;
    image.rows = rows_;
    return raster::encode_png(image, 6);
}

Colour scale_colour(double t) {
    static constexpr double kStops[6][3] = {{68, 1, 84},   {59, 82, 139},  {33, 145, 140},
                                            {94, 201, 98}, {253, 231, 37}, {253, 231, 37}};
    const double at = std::clamp(t, 0.0, 1.0) * 4;
    const auto i = static_cast<size_t>(at);
    const double f = at - static_cast<double>(i);
    Colour out;
    for (size_t c = 0; c < 3; ++c)
        out[c] =
            static_cast<uint8_t>(std::lround(kStops[i][c] + f * (kStops[i + 1][c] - kStops[i][c])));
    return out;
}

}  // namespace openfab::mechanics
