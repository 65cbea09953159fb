// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/picture.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/raster/png_encode.h"
#include "base/color.h"
#include "base/units.h"
#include "tools/color/messages.h"
#include "tools/texture/decoder.h"
#include "tools/texture/still_image.h"

namespace openfab::color {

namespace {

constexpr int64_t kMostPixels = 64'000'000;

Result<void> decode(tools::StillImage* image, std::vector<Rgb>* pixels) {
    const tools::Decoder decoder(image->spec(), image->color(), {});
    const int width = image->spec().width;
    const bool grey = decoder.channels_in() < 3;
    return image->each_row([&](int y, const float* pixel) -> Result<void> {
        for (int x = 0; x < width; ++x) {
            std::array<float, 4> v{};
            if (!decoder.pixel(pixel, v.data()))
                return user_error(fmt::format(messages::kPixelNotFinite, x, y));
            pixels->push_back({static_cast<double>(v[0]), static_cast<double>(v[grey ? 0 : 1]),
                               static_cast<double>(v[grey ? 0 : 2])});
            pixel += decoder.channels_in();
        }
        return {};
    });
}

}  // namespace

Result<Picture> Picture::read(const std::filesystem::path& file) {
    const auto named = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBefore, file.string()));
    };
    try {
        const Result<std::unique_ptr<tools::StillImage>> image =
            tools::StillImage::open(file, kDefaultMemoryBytes);
        if (!image) return named(image.error());
        const OIIO::ImageSpec& spec = (*image)->spec();
        if (spec.nchannels > 4) {
            return named(user_error(fmt::format(messages::kChannels, spec.nchannels)));
        }
        if (int64_t{spec.width} * spec.height > kMostPixels) {
            return named(user_error(fmt::format(messages::kPixelCount, spec.width, spec.height),
                                    messages::kPixelCountHelp));
        }
        Picture out;
        out.width_ = spec.width;
        out.height_ = spec.height;
        if (Result<void> read = decode(image->get(), &out.pixels_); !read)
            return named(read.error());
        return out;
    } catch (const std::exception& e) {
        return named(user_error(e.what()));
    }
}

const Rgb& Picture::at(int x, int y) const {
    const auto column = static_cast<size_t>(std::clamp(x, 0, width_ - 1));
    const auto row = static_cast<size_t>(std::clamp(y, 0, height_ - 1));
    return pixels_[row * static_cast<size_t>(width_) + column];
}

Result<std::vector<uint8_t>> png_of(int width, int height, const std::vector<Rgb>& pixels) {
    std::vector<uint8_t> rows;
    rows.reserve(pixels.size() * 3 + static_cast<size_t>(height));
    for (int y = 0; y < height; ++y) {
        rows.push_back(0);
        for (int x = 0; x < width; ++x) {
            for (const double channel : pixels[static_cast<size_t>(y) * static_cast<size_t>(width) +
                                               static_cast<size_t>(x)])
                rows.push_back(linear_to_srgb8(channel));
        }
    }
    raster::PngImage image;
    image.width = width;
    image.height = height;
    image.color = raster::PngColor::kRgb;
    image.rows = rows;
    image.text = "OpenFab";
    constexpr int kLevel = 6;
    std::vector<uint8_t> png = raster::encode_png(image, kLevel);
    if (png.empty()) return outside_error(messages::kNoMemoryForPicture);
    return png;
}

}  // namespace openfab::color
