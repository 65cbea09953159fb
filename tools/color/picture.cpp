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
#include "tools/texture/icc_context.h"
#include "tools/texture/messages.h"
#include "tools/texture/orientation.h"
#include "tools/texture/still_image.h"

namespace openfab::color {

namespace {

constexpr int64_t kMostPixels = 64'000'000;

/// Decodes all pixels, and puts them where they are in the upright picture.
Result<void> decode(tools::StillImage* image, const tools::Decoder& decoder,
                    const tools::Orientation& turned, std::vector<Rgb>* pixels) {
    const int width = image->spec().width, height = image->spec().height;
    const int across = turned.swap ? height : width, down = turned.swap ? width : height;
    const bool grey = decoder.channels_in() < 3;
    pixels->resize(static_cast<size_t>(width) * static_cast<size_t>(height));
    return image->each_row([&](int y, const float* pixel) -> Result<void> {
        for (int x = 0; x < width; ++x) {
            std::array<float, 4> v{};
            if (!decoder.pixel(pixel, v.data()))
                return user_error(fmt::format(messages::kPixelNotFinite, x, y));
            int column = turned.swap ? y : x, row = turned.swap ? x : y;
            if (turned.mirror_x) column = across - 1 - column;
            if (turned.mirror_y) row = down - 1 - row;
            (*pixels)[static_cast<size_t>(row) * static_cast<size_t>(across) +
                      static_cast<size_t>(column)] = {static_cast<double>(v[0]),
                                                      static_cast<double>(v[grey ? 0 : 1]),
                                                      static_cast<double>(v[grey ? 0 : 2])};
            pixel += decoder.channels_in();
        }
        return {};
    });
}

/// Of a profile of the input class that is read, its white; a profile that is damaged says nothing.
std::optional<Xyz> white_of_input(const std::vector<uint8_t>& profile) {
    const tools::IccContext context;
    const tools::CmsProfile opened = context.open(profile);
    if (opened == nullptr || cmsGetDeviceClass(opened.get()) != cmsSigInputClass) return {};
    const auto* const white =
        static_cast<const cmsCIEXYZ*>(cmsReadTag(opened.get(), cmsSigMediaWhitePointTag));
    constexpr double kDarkest = 0.05, kLightest = 2;
    if (white == nullptr) return {};
    for (const double v : {white->X, white->Y, white->Z})
        if (!(v > kDarkest && v < kLightest)) return {};
    return Xyz{white->X, white->Y, white->Z};
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
        const tools::Orientation turned(spec.get_int_attribute("Orientation", 1));
        out.name_ = file.string();
        out.width_ = turned.swap ? spec.height : spec.width;
        out.height_ = turned.swap ? spec.width : spec.height;
        const tools::FileColor color = (*image)->color();
        const tools::Decoder decoder(spec, color, {});
        if (decoder.note() != nullptr)
            out.note_ = fmt::format(tools::messages::kNoteOnColors, file.string(), decoder.note());
        out.input_white_ = white_of_input(color.profile);
        out.by_camera_ = spec.find_attribute("ExposureTime") != nullptr ||
                         spec.find_attribute("FNumber") != nullptr;
        if (Result<void> read = decode(image->get(), decoder, turned, &out.pixels_); !read)
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
