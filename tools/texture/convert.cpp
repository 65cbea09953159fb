// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "runtime/texture/pyramid_file.h"
#include "tools/texture/decoder.h"

namespace openfab::tools {
namespace {

using texture::ImageOptions;

/// Where pixel (x, y) of the file, y down, lands in level 0, whose rows go up.
struct Placement {
    int64_t start = 0, step_x = 0, step_y = 0;  ///< in texels
    int32_t width = 0, height = 0;              ///< of level 0
};

/// EXIF orientations: bit pattern of (swap axes, mirror x, mirror y) of the upright picture.
Placement placement_for(int32_t width, int32_t height, int orientation) {
    const bool swap = orientation >= 5;
    const bool mirror_x =
        orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
    const bool mirror_y =
        orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
    Placement p;
    p.width = swap ? height : width;
    p.height = swap ? width : height;
    // Steps in the upright picture along its own x (right) and y (down).
    const int64_t right = mirror_x ? -1 : 1;
    const int64_t down = (mirror_y ? -1 : 1) * -static_cast<int64_t>(p.width);
    p.start = (mirror_x ? p.width - 1 : 0) +
              (mirror_y ? 0 : static_cast<int64_t>(p.height - 1) * p.width);
    p.step_x = swap ? down : right;
    p.step_y = swap ? right : down;
    return p;
}

/// Reads rows [begin, end) as floats.
bool read_rows(OIIO::ImageInput* in, const OIIO::ImageSpec& spec, int begin, int end, float* out) {
    const int y0 = spec.y + begin;
    const int y1 = spec.y + end;
    if (spec.tile_width > 0) {
        return in->read_tiles(0, 0, spec.x, spec.x + spec.width, y0, y1, spec.z, spec.z + 1, 0,
                              spec.nchannels, OIIO::TypeDesc::FLOAT, out);
    }
    return in->read_scanlines(0, 0, y0, y1, spec.z, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, out);
}

Result<void> convert(const std::filesystem::path& image, const std::filesystem::path& out,
                     const ImageOptions& options) {
    const auto bad = [&](const std::string& why) {
        return user_error(fmt::format("cannot read {}: {}", image.string(), why));
    };
    OIIO::ImageSpec config;
    // Alpha is one more channel for a fablet; colours must not arrive multiplied by it.
    config.attribute("oiio:UnassociatedAlpha", 1);
    const std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::open(image.string(), &config);
    if (in == nullptr) return bad(reader_trouble(OIIO::geterror()));
    const OIIO::ImageSpec spec = in->spec();
    if (spec.depth > 1) return bad("it is a volume, not a picture");
    if (spec.nchannels > 4)
        return bad(fmt::format("it has {} channels; 1 to 4 are possible", spec.nchannels));
    const Decoder decoder(spec, options);
    const int orientation = spec.get_int_attribute("Orientation", 1);
    const Placement place = placement_for(spec.width, spec.height, orientation);
    Result<texture::PyramidLayout> layout =
        texture::pyramid_layout(place.width, place.height, decoder.channels_out());
    if (!layout) return bad(layout.error().message);
    const Result<uint64_t> key = texture::content_key(image, options);
    if (!key) return key.error();
    Result<std::unique_ptr<texture::PyramidWriter>> writer =
        texture::PyramidWriter::create(out, *layout, *key);
    if (!writer) return writer.error();
    float* level0 = (*writer)->level0();

    constexpr int kRows = 64;
    const int step = spec.tile_height > 0 ? spec.tile_height : kRows;
    const auto row_floats = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.nchannels);
    std::vector<float> rows(row_floats * static_cast<size_t>(std::min(step, spec.height)));
    for (int begin = 0; begin < spec.height; begin += step) {
        const int end = std::min(begin + step, spec.height);
        if (!read_rows(in.get(), spec, begin, end, rows.data()))
            return bad(reader_trouble(in->geterror()));
        const float* pixel = rows.data();
        for (int64_t y = begin; y < end; ++y) {
            int64_t texel = place.start + y * place.step_y;
            for (int x = 0; x < spec.width; ++x) {
                if (!decoder.pixel(pixel, level0 + texel * decoder.channels_out())) {
                    return bad(fmt::format("pixel ({}, {}) is not a finite number", x, y));
                }
                pixel += decoder.channels_in();
                texel += place.step_x;
            }
        }
    }
    return (*writer)->finish();
}

}  // namespace

Result<void> make_pyramid_file(const std::filesystem::path& image, const std::filesystem::path& out,
                               const ImageOptions& options) {
    if (options.space != "auto" && options.space != "srgb" && options.space != "linear" &&
        options.space != "data") {
        return usage_error(fmt::format(
            "unknown space `{}`; known: `auto`, `srgb`, `linear`, `data`", options.space));
    }
    // Two pictures are a fraction of a second; threads of a library would outlive them.
    OIIO::attribute("threads", 1);
    // Refuses headers that ask for absurd memory before it is allocated: 16k x 16k x 4 floats.
    OIIO::attribute("limits:imagesize_MB", 5000);
    try {
        return convert(image, out, options);
    } catch (const std::exception& e) {
        return user_error(fmt::format("cannot read {}: {}", image.string(), e.what()));
    }
}

}  // namespace openfab::tools
