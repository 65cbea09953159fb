// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/texture_look.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <tuple>
#include <utility>

#include "backends/raster/png_encode.h"
#include "texture/cache.h"
#include "texture/pyramid.h"
#include "texture/volume.h"
#include "tools/viewer/messages.h"
#include "world/texture_options.h"

namespace openfab::viewer {

namespace {

constexpr int32_t kSide = 64;
constexpr int kLookPngLevel = 1;

struct Level {
    int32_t width = 0, height = 0, depth = 1;
    const float* texels = nullptr;
};

/// The finest that is small enough.
Level small_level(const texture::Pyramid& pyramid) {
    const std::span<const int32_t> info = pyramid.info();
    const bool volume = pyramid.is_volume();
    const size_t header =
        static_cast<size_t>(volume ? texture::kVolumeInfoHeader : texture::kInfoHeader);
    const size_t each =
        static_cast<size_t>(volume ? texture::kVolumeInfoPerLevel : texture::kInfoPerLevel);
    Level level;
    for (size_t l = 0; l < static_cast<size_t>(pyramid.levels()); ++l) {
        const std::span<const int32_t> row = info.subspan(header + l * each, each);
        level = {row[1], row[2], volume ? row[3] : 1, pyramid.texels().data() + row[0]};
        if (std::max(level.width, level.height) <= kSide) break;
    }
    return level;
}

double to_srgb(double v) {
    v = std::clamp(v, 0.0, 1.0);
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

std::vector<uint8_t> picture_of(const texture::Pyramid& pyramid, bool is_data) {
    const Level level = small_level(pyramid);
    const auto channels = static_cast<size_t>(pyramid.channels());
    const auto width = static_cast<size_t>(level.width);
    const auto height = static_cast<size_t>(level.height);
    const std::span<const float> texels(
        level.texels + static_cast<size_t>(level.depth / 2) * width * height * channels,
        width * height * channels);
    float low = 0, high = 1;
    if (is_data) {
        const auto [least, most] = std::minmax_element(texels.begin(), texels.end());
        if (*most > *least) std::tie(low, high) = std::pair(*least, *most);
    }
    raster::PngImage image;
    image.width = level.width;
    image.height = level.height;
    image.color = raster::PngColor::kRgb;
    std::vector<uint8_t> rows;
    rows.reserve(height * (1 + 3 * width));
    for (size_t y = height; y-- > 0;) {
        rows.push_back(0);
        for (size_t x = 0; x < width; ++x) {
            const float* texel = &texels[(y * width + x) * channels];
            for (size_t c = 0; c < 3; ++c) {
                // Two channels are grey and alpha, or two numbers.
                const float v = channels >= 3              ? texel[c]
                                : channels == 2 && is_data ? (c < 2 ? texel[c] : low)
                                                           : texel[0];
                const double share =
                    is_data ? (double{v} - low) / (double{high} - low) : to_srgb(v);
                rows.push_back(static_cast<uint8_t>(
                    std::isfinite(share) ? std::lround(255 * std::clamp(share, 0.0, 1.0)) : 0));
            }
        }
    }
    image.rows = rows;
    return raster::encode_png(image, kLookPngLevel);
}

}  // namespace

Result<std::vector<uint8_t>> texture_look(const world::Texture& texture, bool is_volume,
                                          const std::vector<std::filesystem::path>& roots) {
    const auto wrap = static_cast<int32_t>(texture.wrap);
    texture::ReadLimits limits;
    limits.roots = roots;
    const Result<std::shared_ptr<const texture::Pyramid>> pyramid =
        is_volume ? texture::get_volume(texture.file, world::volume_options(texture), wrap,
                                        texture::kFilterTrilinear, limits)
                  : texture::get_pyramid(texture.file, world::image_options(texture), wrap,
                                         texture::kFilterTrilinear, limits);
    if (!pyramid) return pyramid.error();
    std::vector<uint8_t> png =
        picture_of(**pyramid, is_volume || texture.space == world::Space::kData);
    if (png.empty()) return outside_error(messages::kMemoryRanOut);
    return png;
}

}  // namespace openfab::viewer
