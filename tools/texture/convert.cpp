// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <array>

#include "texture/pyramid_file.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/decoder.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/orientation.h"
#include "tools/texture/picture_format.h"
#include "tools/texture/still_image.h"

namespace openfab::tools {
namespace {

using texture::ImageOptions;

Error not_finite(int x, int y) {
    return user_error(fmt::format(messages::kPixelNotFinite, x, y));
}

/// Maps pixel (x, y) of the file, y down, to level 0, whose rows go up.
struct Placement {
    int64_t start = 0, step_x = 0, step_y = 0;  ///< in texels
    int32_t width = 0, height = 0;              ///< of level 0
};

Placement placement_for(int32_t width, int32_t height, const Orientation& turned) {
    Placement p;
    p.width = turned.swap ? height : width;
    p.height = turned.swap ? width : height;
    // Steps in the upright picture along its own x (right) and y (down).
    const int64_t right = turned.mirror_x ? -1 : 1;
    const int64_t down = (turned.mirror_y ? -1 : 1) * -static_cast<int64_t>(p.width);
    p.start = (turned.mirror_x ? p.width - 1 : 0) +
              (turned.mirror_y ? 0 : static_cast<int64_t>(p.height - 1) * p.width);
    p.step_x = turned.swap ? down : right;
    p.step_y = turned.swap ? right : down;
    return p;
}

/// Decodes all pixels.
Result<void> try_rows(StillImage* in, const Decoder& decoder) {
    const int32_t width = in->spec().width;
    return in->each_row([&](int y, const float* pixel) -> Result<void> {
        for (int x = 0; x < width; ++x, pixel += decoder.channels_in()) {
            std::array<float, 4> texel{};
            if (!decoder.pixel(pixel, texel.data())) return not_finite(x, y);
        }
        return {};
    });
}

/// Writes nothing where `out` is empty.
Result<void> convert(const std::filesystem::path& image, const std::filesystem::path& out,
                     const ImageOptions& options, const texture::ReadLimits& limits, bool guarded) {
    const auto bad = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBefore, image.string()));
    };
    const Result<std::unique_ptr<StillImage>> in =
        StillImage::open(image, limits.memory_bytes, guarded);
    if (!in) return bad(in.error());
    const OIIO::ImageSpec spec = (*in)->spec();
    if (spec.nchannels > 4) {
        return bad(user_error(fmt::format(messages::kPictureChannels, spec.nchannels,
                                          fmt::join(spec.channelnames, ", "))));
    }
    if (!(*in)->left_out().empty()) {
        tell(fmt::format(messages::kChannelsLeftOut, image.filename().string(),
                         fmt::join((*in)->left_out(), ", ")));
    }
    const Decoder decoder(spec, (*in)->color(), options);
    const Orientation turned(spec.get_int_attribute("Orientation", 1));
    const Placement placement = placement_for(spec.width, spec.height, turned);
    Result<texture::PyramidLayout> layout =
        texture::pyramid_layout(placement.width, placement.height, decoder.channels_out());
    if (!layout) return bad(layout.error());
    layout->alpha = decoder.alpha_out();
    if (Result<void> fits = check_memory(texture::pyramid_file_bytes(*layout), limits.memory_bytes);
        !fits)
        return bad(fits.error());
    const auto tell_rest = [&] {
        const char* const unknown = decoder.note();
        if (unknown != nullptr)
            tell(fmt::format(messages::kNoteOnColors, image.filename().string(), unknown));
        if (!(*in)->has_more()) return;
        tell(fmt::format(messages::kSeveralPictures, image.filename().string()));
    };
    if (out.empty()) {
        const Result<void> read = try_rows(in->get(), decoder);
        if (!read) return bad(read.error());
        tell_rest();
        return {};
    }
    const Result<uint64_t> key = texture::content_key(image, options);
    if (!key) return key.error();
    Result<std::unique_ptr<texture::PyramidWriter>> writer =
        texture::PyramidWriter::create(out, *layout, *key);
    if (!writer) return writer.error();
    float* level0 = (*writer)->level0();
    // A row that becomes a column touches a page per texel, and the next rows touch the same pages.
    constexpr int64_t kBytesOfColumn = 128;
    const int64_t row_bytes =
        spec.width * (turned.swap ? kBytesOfColumn : 4 * int64_t{decoder.channels_out()});
    const Result<void> read = (*in)->each_row([&](int y, const float* pixel) -> Result<void> {
        int64_t texel = placement.start + y * placement.step_y;
        for (int x = 0; x < spec.width; ++x) {
            if (!decoder.pixel(pixel, level0 + texel * decoder.channels_out()))
                return not_finite(x, y);
            pixel += decoder.channels_in();
            texel += placement.step_x;
        }
        (*writer)->wrote(row_bytes);
        return {};
    });
    if (!read) return bad(read.error());
    tell_rest();
    return (*writer)->finish();
}

/// Whether it is read in a child process. What cannot be opened is reported by `convert`.
bool is_fragile(const std::filesystem::path& image) {
    const Result<InputFile> file = InputFile::open(image);
    const Result<PictureFormat> format = file ? picture_format(*file) : file.error();
    return format && format->fragile;
}

Result<void> convert_safely(const std::filesystem::path& image, const std::filesystem::path& out,
                            const ImageOptions& options, const texture::ReadLimits& limits) {
    if (options.space != "auto" && options.space != "srgb" && options.space != "linear" &&
        options.space != "data") {
        return usage_error(fmt::format(messages::kUnknownSpace, options.space));
    }
    // Pictures take a fraction of a second; the library's threads would outlive them.
    OIIO::attribute("threads", 1);
    // None of OpenEXR's: each has buffers of its own, for lines as wide as a header says.
    OIIO::attribute("exr_threads", -1);
    // Refuses headers that ask for absurd memory before it is allocated: 16k x 16k x 4 floats.
    OIIO::attribute("limits:imagesize_MB", 5000);
    const auto read = [&]() -> Result<void> {
        try {
            return convert(image, out, options, limits, true);
        } catch (const std::exception& e) {
            return user_error(fmt::format(messages::kCannotRead, image.string(), e.what()));
        }
    };
    return is_fragile(image) ? guarded(limits.memory_bytes, image, read, out) : read();
}

}  // namespace

Result<void> make_pyramid_file(const std::filesystem::path& image, const std::filesystem::path& out,
                               const ImageOptions& options, const texture::ReadLimits& limits) {
    return convert_safely(image, out, options, limits);
}

Result<void> check_picture_file(const std::filesystem::path& image, const ImageOptions& options,
                                const texture::ReadLimits& limits) {
    return convert_safely(image, {}, options, limits);
}

}  // namespace openfab::tools
