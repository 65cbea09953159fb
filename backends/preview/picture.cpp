// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/preview/picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "backends/raster/png_encode.h"
#include "base/color.h"

namespace openfab::preview {

namespace {

constexpr int32_t kMaxSide = 2000;
constexpr double kMaxPixels = 2e6;

/// How the cells of one axis are distributed over the pixels: pixel p takes cells first … first +
/// weights.size() - 1.
struct Share {
    int32_t first = 0;
    std::vector<double> weights;  ///< they add up to 1
};

std::vector<Share> shares(int32_t cells, int32_t pixels) {
    std::vector<Share> result(static_cast<size_t>(pixels));
    const double ratio = static_cast<double>(cells) / pixels;
    for (int32_t p = 0; p < pixels; ++p) {
        const double from = p * ratio;
        const double to = (p + 1) * ratio;
        Share& share = result[p];
        share.first = std::min(static_cast<int32_t>(std::floor(from)), cells - 1);
        for (int32_t c = share.first; c < cells && c < to; ++c) {
            const double weight = std::min<double>(to, c + 1) - std::max<double>(from, c);
            share.weights.push_back(std::max(weight, 0.0) / ratio);
        }
    }
    return result;
}

void add(Pixel* sum, const Pixel& pixel, double weight) {
    const double covered = weight * pixel.coverage;
    for (int c = 0; c < 3; ++c)
        sum->color[c] += covered * pixel.color[c];
    sum->height_mm += covered * pixel.height_mm;
    sum->coverage += covered;
}

Pixel mean(const Pixel& sum) {
    Pixel pixel = sum;
    if (sum.coverage <= 0) return {};
    for (float& c : pixel.color)
        c /= sum.coverage;
    pixel.height_mm /= sum.coverage;
    return pixel;
}

uint8_t paeth(int left, int up, int corner) {
    const int guess = left + up - corner;
    const int dl = std::abs(guess - left);
    const int du = std::abs(guess - up);
    const int dc = std::abs(guess - corner);
    return static_cast<uint8_t>(dl <= du && dl <= dc ? left : du <= dc ? up : corner);
}

}  // namespace

Picture resample(int32_t width, int32_t height, const std::array<double, 2>& cell_mm,
                 const std::function<Pixel(int32_t x, int32_t y)>& cell) {
    const double fine = std::min(cell_mm[0], cell_mm[1]);
    const double wide = width * cell_mm[0] / fine;
    const double high = height * cell_mm[1] / fine;
    // Integer multiples keep the dither's grain uniform.
    const double times = std::max({1.0, std::ceil(std::max(wide, high) / kMaxSide),
                                   std::ceil(std::sqrt(wide * high / kMaxPixels))});
    Picture picture;
    picture.pixel_mm = fine * times;
    picture.width = std::max(1, static_cast<int32_t>(std::floor(wide / times + 0.5)));
    picture.height = std::max(1, static_cast<int32_t>(std::floor(high / times + 0.5)));
    picture.pixels.resize(static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height));
    const std::vector<Share> columns = shares(width, picture.width);
    const std::vector<Share> rows = shares(height, picture.height);
    std::vector<Pixel> source(static_cast<size_t>(width));
    for (int32_t y = 0; y < picture.height; ++y) {
        const Share& row = rows[y];
        for (size_t r = 0; r < row.weights.size(); ++r) {
            for (int32_t x = 0; x < width; ++x) {
                source[x] = cell(x, row.first + static_cast<int32_t>(r));
            }
            for (int32_t x = 0; x < picture.width; ++x) {
                const Share& column = columns[x];
                for (size_t c = 0; c < column.weights.size(); ++c) {
                    add(&picture.at(x, y), source[static_cast<size_t>(column.first) + c],
                        row.weights[r] * column.weights[c]);
                }
            }
        }
        for (int32_t x = 0; x < picture.width; ++x)
            picture.at(x, y) = mean(picture.at(x, y));
    }
    return picture;
}

namespace {

constexpr size_t kChannels = 4;

void encode_row(const Picture& picture, int32_t y, uint8_t* out) {
    for (int32_t x = 0; x < picture.width; ++x, out += kChannels) {
        const Pixel& pixel = picture.at(x, y);
        for (int c = 0; c < 3; ++c)
            out[c] = linear_to_srgb8(pixel.color[c]);
        out[3] =
            static_cast<uint8_t>(std::floor(std::clamp(pixel.coverage, 0.0F, 1.0F) * 255 + 0.5F));
    }
}

}  // namespace

std::vector<uint8_t> to_rgba8(const Picture& picture) {
    const size_t row_bytes = static_cast<size_t>(picture.width) * kChannels;
    std::vector<uint8_t> out(row_bytes * static_cast<size_t>(picture.height));
    for (int32_t y = 0; y < picture.height; ++y)
        encode_row(picture, y, out.data() + static_cast<size_t>(y) * row_bytes);
    return out;
}

std::vector<uint8_t> to_png(const Picture& picture) {
    constexpr uint8_t kPaethFilter = 4;
    constexpr int kLevel = 6;
    const size_t row_bytes = static_cast<size_t>(picture.width) * kChannels;
    std::vector<uint8_t> filtered;
    filtered.reserve((row_bytes + 1) * static_cast<size_t>(picture.height));
    std::vector<uint8_t> above(row_bytes);
    std::vector<uint8_t> row(row_bytes);
    for (int32_t y = 0; y < picture.height; ++y) {
        encode_row(picture, y, row.data());
        filtered.push_back(kPaethFilter);
        for (size_t i = 0; i < row_bytes; ++i) {
            const int left = i >= kChannels ? row[i - kChannels] : 0;
            const int corner = i >= kChannels ? above[i - kChannels] : 0;
            filtered.push_back(static_cast<uint8_t>(row[i] - paeth(left, above[i], corner)));
        }
        row.swap(above);
    }
    raster::PngImage image;
    image.width = picture.width;
    image.height = picture.height;
    image.rows = filtered;
    image.pixels_per_metre_x = image.pixels_per_metre_y = 1000 / picture.pixel_mm;
    image.text = "OpenFab";
    return raster::encode_png(image, kLevel);
}

}  // namespace openfab::preview
