// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Pictures and volumes of arrays, put into the cache of pyramids in this process. Python writes an
// array to a file, which a world names; a print would start the converter for it, which takes a third
// of a second before it reads a pixel. What is kept here has the bytes of the converter's
// (tools/texture/decoder.h), which is asked where anything here does not work out.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "base/color.h"
#include "python/src/bindings.h"
#include "texture/cache.h"
#include "texture/pyramid_file.h"
#include "texture/volume.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace openfab::python {

namespace {

namespace fs = std::filesystem;

/// Larger ones are left to the converter, which minds `memory`.
constexpr int64_t kMostBytes = 256 << 20;

template <typename T>
using Texels = nb::ndarray<const T, nb::c_contig, nb::device::cpu>;
using Origin = std::optional<std::array<double, 3>>;

/// A number of a volume; integers are parts of the largest.
float stored(uint8_t value) {
    return static_cast<float>(static_cast<double>(value) / 255);
}
float stored(uint16_t value) {
    return static_cast<float>(static_cast<double>(value) / 65535);
}
float stored(float value) {
    return value;
}

/// A number of a picture, as OpenImageIO scales it.
float read(uint8_t value) {
    return static_cast<float>(value) * (1.0f / 255);
}
float read(uint16_t value) {
    return static_cast<float>(value) * (1.0f / 65535);
}
float read(float value) {
    return value;
}

/// A number of a picture as light: 8 bits are sRGB unless `space` says otherwise. Python's PNG of 16 bits
/// has a gamma of 1, whose power is rounded.
template <typename T>
float light(T value, const std::string& space) {
    const float number = read(value);
    if (space == "srgb" || (space == "auto" && sizeof(T) == 1))
        return static_cast<float>(srgb_to_linear(sizeof(T) == 1 ? static_cast<double>(value) / 255
                                                                : static_cast<double>(number)));
    if (space != "auto" || sizeof(T) != 2) return number;
    constexpr double kOne = 1 << 20;
    return static_cast<float>(std::floor(static_cast<double>(number) * kOne + 0.5) / kOne);
}

/// Writes the pyramid of a key to the cache unless it is there; `fill` writes level 0.
template <typename Fill>
bool keep(uint64_t key, const texture::PyramidLayout& layout, const Fill& fill) {
    if (!texture::keeps_textures()) return false;
    const Result<fs::path> cache = texture::cache_folder();
    if (!texture::check_keeps(cache)) return false;
    const fs::path file = *cache / texture::cache_name(key);
    std::error_code ignored;
    if (fs::exists(file, ignored)) return true;
    if (texture::pyramid_file_bytes(layout) > kMostBytes) return false;
    Result<std::unique_ptr<texture::PyramidWriter>> writer =
        texture::PyramidWriter::create(file, layout, key);
    if (!writer) return false;
    fill((*writer)->level0());
    return static_cast<bool>((*writer)->finish());
}

/// `texels` are [row][column][1 or 3], the top row first.
template <typename T>
bool keep_picture(const fs::path& file, const Texels<T>& texels, const std::string& space,
                  bool luminance) {
    if (texels.ndim() != 3) return false;
    const auto height = static_cast<int32_t>(texels.shape(0));
    const auto width = static_cast<int32_t>(texels.shape(1));
    const auto channels = static_cast<int32_t>(texels.shape(2));
    if (channels != 1 && channels != 3) return false;
    const int32_t made = luminance ? 1 : channels;
    const Result<texture::PyramidLayout> layout = texture::pyramid_layout(width, height, made);
    const Result<uint64_t> key = texture::content_key(file, {space, luminance, false});
    if (!layout || !key) return false;
    return keep(*key, *layout, [&](float* out) {
        for (int32_t y = height - 1; y >= 0; --y) {
            const T* in = texels.data() + int64_t{y} * width * channels;
            for (int32_t x = 0; x < width; ++x, in += channels) {
                std::array<float, 3> color{};
                for (int32_t c = 0; c < channels; ++c)
                    color[static_cast<size_t>(c)] = light(in[c], space);
                if (luminance && channels == 3)
                    color[0] = openfab::luminance(color[0], color[1], color[2]);
                out = std::copy_n(color.data(), made, out);
            }
        }
    });
}

/// `texels` are [z][y][x] or [z][y][x][channel].
template <typename T>
bool keep_volume(const fs::path& file, const Texels<T>& texels, const Origin& origin,
                 const Origin& spacing) {
    if (texels.ndim() != 3 && texels.ndim() != 4) return false;
    const Vec3i size{static_cast<int32_t>(texels.shape(2)), static_cast<int32_t>(texels.shape(1)),
                     static_cast<int32_t>(texels.shape(0))};
    const auto channels = static_cast<int32_t>(texels.ndim() == 4 ? texels.shape(3) : 1);
    texture::VolumeOptions options;
    options.origin_mm = origin;
    options.spacing_mm = spacing;
    texture::VolumeDomain domain;
    for (size_t a = 0; a < 3; ++a) {
        domain.origin[a] = static_cast<float>(origin ? (*origin)[a] : 0);
        domain.extent[a] =
            static_cast<float>((spacing ? (*spacing)[a] : 1) * size[static_cast<int>(a)]);
    }
    const Result<texture::PyramidLayout> layout = texture::volume_layout(size, channels, domain);
    const Result<uint64_t> key = texture::volume_key(file, options);
    if (!layout || !key) return false;
    const T* const begin = texels.data();
    return keep(*key, *layout, [&](float* out) {
        std::transform(begin, begin + texels.size(), out, [](T value) { return stored(value); });
    });
}

template <typename T>
void bind_kind(nb::module_& m) {
    m.def("keep_picture", &keep_picture<T>, "file"_a, "texels"_a, "space"_a, "luminance"_a,
          nb::call_guard<nb::gil_scoped_release>());
    m.def("keep_volume", &keep_volume<T>, "file"_a, "texels"_a, "origin_mm"_a, "spacing_mm"_a,
          nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace

void bind_texels(nb::module_& m) {
    bind_kind<uint8_t>(m);
    bind_kind<uint16_t>(m);
    bind_kind<float>(m);
}

}  // namespace openfab::python
