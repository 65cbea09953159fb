// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "runtime/texture/pyramid_file.h"
#include "tools/texture/decoder.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Slices by OpenImageIO.
class StackReader final : public VolumeReader {
  public:
    StackReader(std::vector<fs::path> files, const texture::ImageOptions& options)
        : files_(std::move(files)), options_(options) {}

    Result<void> open() {
        if (Result<void> first = look_at(0); !first) return first.error();
        size.x = spec_.width;
        size.y = spec_.height;
        size.z = static_cast<int32_t>(files_.size());
        if (files_.size() == 1) {
            int pages = 1;
            while (input_->seek_subimage(pages, 0))
                ++pages;
            size.z = pages;
        }
        if (spec_.nchannels > 4)
            return user_error(
                fmt::format("it has {} channels; 1 to 4 are possible", spec_.nchannels));
        channels = options_.luminance ? 1 : spec_.nchannels;
        return Ok{};
    }

    Result<void> read(float* out) override {
        texture::ImageOptions options = options_;
        // Slices are mostly measures; only pictures in colour are taken for pictures.
        const bool colour = spec_.format.basetype == OIIO::TypeDesc::UINT8 && spec_.nchannels >= 3;
        if (options.space == "auto") options.space = colour ? "srgb" : "linear";
        const Decoder decoder(spec_, options);
        std::vector<float> pixels(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) *
                                  static_cast<size_t>(spec_.nchannels));
        for (int32_t z = 0; z < size.z; ++z) {
            if (Result<void> slice = read_slice(z, pixels.data()); !slice) return slice.error();
            const float* pixel = pixels.data();
            float* row = out + static_cast<int64_t>(z) * size.y * size.x * channels;
            for (int32_t y = 0; y < size.y; ++y) {
                for (int32_t x = 0; x < size.x; ++x) {
                    if (!decoder.pixel(pixel, row))
                        return user_error(fmt::format(
                            "pixel ({}, {}) of slice {} is not a finite number", x, y, z));
                    pixel += spec_.nchannels;
                    row += channels;
                }
            }
        }
        return Ok{};
    }

  private:
    Result<void> look_at(size_t file) {
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        input_ = OIIO::ImageInput::open(files_[file].string(), &config);
        if (input_ == nullptr) return user_error(named(file, reader_trouble(OIIO::geterror())));
        spec_ = input_->spec();
        return Ok{};
    }

    std::string named(size_t file, const std::string& trouble) const {
        return files_.size() == 1
                   ? trouble
                   : fmt::format("{}: {}", files_[file].filename().string(), trouble);
    }

    Result<void> read_slice(int32_t z, float* pixels) {
        const bool pages = files_.size() == 1;
        const auto file = static_cast<size_t>(pages ? 0 : z);
        if (!pages) {
            if (Result<void> opened = look_at(file); !opened) return opened.error();
        }
        const int page = pages ? z : 0;
        if (!input_->seek_subimage(page, 0))
            return user_error(named(file, reader_trouble(input_->geterror())));
        const OIIO::ImageSpec& spec = input_->spec();
        if (spec.width != size.x || spec.height != size.y || spec.nchannels != spec_.nchannels ||
            spec.depth > 1) {
            return user_error(named(
                file,
                fmt::format("slice {} is {} x {} with {} channels, the first is {} x {} with {}", z,
                            spec.width, spec.height, spec.nchannels, size.x, size.y,
                            spec_.nchannels)));
        }
        if (!input_->read_image(page, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels))
            return user_error(named(file, reader_trouble(input_->geterror())));
        return Ok{};
    }

    std::vector<fs::path> files_;
    texture::ImageOptions options_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
};

MadeReader open_any(const std::vector<fs::path>& files, const texture::ImageOptions& options) {
    if (files.size() == 1) {
        std::string kind = files[0].extension().string();
        std::transform(kind.begin(), kind.end(), kind.begin(),
                       [](unsigned char c) { return std::tolower(c); });
        if (kind == ".nrrd" || kind == ".nhdr") return open_nrrd(files[0]);
        if (kind == ".npy") return open_npy(files[0]);
        if (kind == ".cube") return open_cube(files[0]);
        if (kind == ".vdb")
            return user_error("VDB files are not read; write the grid as NPY or NRRD");
    }
    return open_stack(files, options);
}

Result<void> convert(const fs::path& source, const fs::path& out,
                     const texture::VolumeOptions& options) {
    const auto bad = [&](const std::string& why) {
        return user_error(fmt::format("cannot read {}: {}", source.string(), why));
    };
    const Result<std::vector<fs::path>> files = texture::volume_files(source);
    if (!files) return files.error();
    MadeReader reader = open_any(*files, options.image);
    if (!reader) return bad(reader.error().message);
    VolumeReader& volume = **reader;
    const std::array<double, 3> one{1, 1, 1}, zero{};
    const std::array<double, 3> spacing = options.spacing_mm.value_or(volume.spacing.value_or(one));
    const std::array<double, 3> origin = options.origin_mm.value_or(volume.origin.value_or(zero));
    texture::VolumePlace place;
    place.table = volume.table;
    for (size_t a = 0; a < 3; ++a) {
        place.origin[a] = static_cast<float>(origin[a]);
        place.extent[a] = static_cast<float>(spacing[a] * volume.size[static_cast<int>(a)]);
    }
    const Result<texture::PyramidLayout> layout =
        texture::volume_layout(volume.size, volume.channels, place);
    if (!layout) return bad(layout.error().message);
    const Result<uint64_t> key = texture::volume_key(source, options);
    if (!key) return key.error();
    Result<std::unique_ptr<texture::PyramidWriter>> writer =
        texture::PyramidWriter::create(out, *layout, *key);
    if (!writer) return writer.error();
    float* texels = (*writer)->level0();
    if (Result<void> read = volume.read(texels); !read) return bad(read.error().message);
    const int64_t count = static_cast<int64_t>(volume.size.x) * volume.size.y * volume.size.z *
                          static_cast<int64_t>(volume.channels);
    if (!std::all_of(texels, texels + count, [](float x) { return std::isfinite(x); }))
        return bad("it holds a value that is not a finite number");
    return (*writer)->finish();
}

}  // namespace

MadeReader open_stack(const std::vector<fs::path>& files, const texture::ImageOptions& options) {
    auto reader = std::make_unique<StackReader>(files, options);
    if (Result<void> opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

Result<void> make_volume_file(const fs::path& source, const fs::path& out,
                              const texture::VolumeOptions& options) {
    OIIO::attribute("threads", 1);
    OIIO::attribute("limits:imagesize_MB", 5000);
    try {
        return convert(source, out, options);
    } catch (const std::exception& e) {
        return user_error(fmt::format("cannot read {}: {}", source.string(), e.what()));
    }
}

}  // namespace openfab::tools
