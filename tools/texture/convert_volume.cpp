// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert_volume.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "base/input_file.h"
#include "base/text.h"
#include "texture/meta_header.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/decoder.h"
#include "tools/texture/messages.h"
#include "tools/texture/scans.h"
#include "tools/texture/still_image.h"
#include "tools/texture/volume_reader.h"
#include "tools/texture/vtk_file.h"
#include "tools/texture/write_volume.h"
#include "tools/texture/xdmf_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Slices that are pictures.
class StackReader final : public VolumeReader {
  public:
    StackReader(std::vector<fs::path> files, const texture::ImageOptions& options,
                int64_t memory_bytes)
        : files_(std::move(files)), options_(options), memory_bytes_(memory_bytes) {}

    Result<void> open() {
        if (Result<void> first = look_at(0); !first) return first.error();
        spec_ = image_->spec();
        size.x = spec_.width;
        size.y = spec_.height;
        size.z = files_.size() == 1 ? image_->pages() : static_cast<int32_t>(files_.size());
        if (files_.size() == 1 && size.z > StillImage::kMostPages) {
            return user_error(fmt::format(messages::kTooManyPages, StillImage::kMostPages));
        }
        if (spec_.nchannels > 4)
            return user_error(fmt::format(messages::kImageChannels, spec_.nchannels));
        channels = options_.luminance ? 1 : spec_.nchannels;
        // Slices are mostly measurements; only colour images count as pictures.
        const bool colour = spec_.format.basetype == OIIO::TypeDesc::UINT8 && spec_.nchannels >= 3;
        if (options_.space == "auto") options_.space = colour ? "srgb" : "linear";
        decoder_.emplace(spec_, image_->color(), options_, Decoder::Alpha::kNumber);
        return Ok{};
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        if (Result<void> found = find(z); !found) return found.error();
        const auto file = static_cast<size_t>(files_.size() == 1 ? 0 : z);
        const Result<void> read = image_->each_row([&](int y, const float* pixel) -> Result<void> {
            float* row = out + y * row_floats();
            for (int32_t x = 0; x < size.x; ++x) {
                if (!decoder_->pixel(pixel, row))
                    return user_error(fmt::format(messages::kPixelOfSliceNotFinite, x, y, z));
                pixel += spec_.nchannels;
                row += channels;
            }
            wrote(4 * row_floats());
            return {};
        });
        return read ? read : Result<void>(named(file, read.error()));
    }

  private:
    Result<void> look_at(size_t file) {
        Result<std::unique_ptr<StillImage>> image = StillImage::open(files_[file], memory_bytes_);
        if (!image) return named(file, image.error());
        image_ = std::move(*image);
        return Ok{};
    }

    Error named(size_t file, const Error& error) const {
        if (files_.size() == 1) return error;
        return with_context(error, files_[file].filename().string() + ": ");
    }

    /// Selects a slice's page for reading.
    Result<void> find(int32_t z) {
        const bool pages = files_.size() == 1;
        const auto file = static_cast<size_t>(pages ? 0 : z);
        if (!pages) {
            if (Result<void> opened = look_at(file); !opened) return opened.error();
        } else if (Result<void> there = image_->go_to(z); !there) {
            return there;
        }
        const OIIO::ImageSpec& spec = image_->spec();
        if (spec.width == size.x && spec.height == size.y && spec.nchannels == spec_.nchannels)
            return Ok{};
        return named(file,
                     user_error(fmt::format(messages::kSliceOfOtherSize, z, spec.width, spec.height,
                                            spec.nchannels, size.x, size.y, spec_.nchannels)));
    }

    std::vector<fs::path> files_;
    texture::ImageOptions options_;
    int64_t memory_bytes_;
    std::unique_ptr<StillImage> image_;
    OIIO::ImageSpec spec_;
    std::optional<Decoder> decoder_;
};

/// Refuses by name what is a volume and is not read: a picture's error would say nothing of it.
Result<void> refuse_others(const fs::path& file, const std::string& kind, std::string_view begin) {
    if (kind == ".nii" || lower_ascii(file.filename().string()).ends_with(".nii.gz"))
        return user_error(messages::kNotNifti);
    constexpr std::array<std::string_view, 2> kAnalyze{{{"\x5c\x01\0\0", 4}, {"\0\0\x01\x5c", 4}}};
    if (kind == ".hdr" && (begin.starts_with(kAnalyze[0]) || begin.starts_with(kAnalyze[1])))
        return user_error(messages::kAnalyze75, messages::kAnalyze75Help);
    if (kind == ".img") return user_error(messages::kOnlyNumbers, messages::kOnlyNumbersHdrHelp);
    if (kind == ".raw" || kind == ".zraw" || kind == ".bin")
        return user_error(messages::kOnlyNumbers, messages::kOnlyNumbersRawHelp);
    if (kind == ".npz")
        return user_error(messages::kArchiveOfArrays, messages::kArchiveOfArraysHelp);
    if (begin.starts_with("\x89HDF") || kind == ".h5" || kind == ".hdf5" || kind == ".hdf" ||
        kind == ".nc" || kind == ".mnc")
        return user_error(messages::kIsHdf5, messages::kIsHdf5Help);
    for (const char* parallel : {".pvti", ".pvtr", ".pvts", ".pvtu", ".vtm", ".pvd"}) {
        if (kind == parallel) return user_error(messages::kPartsOfGrid, messages::kPartsOfGridHelp);
    }
    for (const char* other : {".mgz", ".mgh", ".exo", ".e", ".msh", ".inp", ".mrc", ".vol"}) {
        if (kind == other)
            return user_error(fmt::format(messages::kVolumesNotRead, kind),
                              messages::kVolumesNotReadHelp);
    }
    return {};
}

/// By signature; only colour tables are recognized by their names.
MadeReader open_any(const std::vector<fs::path>& files, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits) {
    if (files.size() != 1) return open_stack(files, options.image, limits);
    const Result<InputFile> file = InputFile::open(files[0]);
    if (!file) return file.error();
    std::array<char, 16> head{};
    const Result<size_t> got = file->read(0, head.data(), head.size());
    if (!got) return got.error();
    const std::string_view begin(head.data(), *got);
    if (begin.starts_with("NRRD")) return open_nrrd(files[0], options, limits);
    if (begin.starts_with("\x93NUMPY")) return open_npy(files[0]);
    const std::string kind = lower_ascii(files[0].extension().string());
    if (kind == ".cube") return open_cube(files[0], limits);
    if (is_nifti_file(files[0])) return open_nifti(files[0], options, limits);
    if (texture::is_meta_image(files[0])) return open_meta(files[0], options, limits);
    if (begin.starts_with(kLegacyVtk)) return open_vtk(files[0], options, limits);
    for (const char* name : {".vti", ".vtr", ".vts", ".vtu", ".vtk"}) {
        if (kind == name) return open_vtk(files[0], options, limits);
    }
    if (texture::is_xdmf(files[0])) return open_xdmf(files[0], options, limits);
    if (kind == ".nrrd" || kind == ".nhdr") return user_error(messages::kNotNrrd);
    if (kind == ".npy") return user_error(messages::kNotNpy);
    if (Result<void> known = refuse_others(files[0], kind, begin); !known) return known.error();
    return open_stack(files, options.image, limits);
}

}  // namespace

MadeReader open_stack(const std::vector<fs::path>& files, const texture::ImageOptions& options,
                      const texture::ReadLimits& limits) {
    auto reader = std::make_unique<StackReader>(files, options, limits.memory_bytes);
    if (Result<void> opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

Result<void> make_volume_file(const std::filesystem::path& source, const std::filesystem::path& out,
                              const texture::VolumeOptions& options,
                              const texture::ReadLimits& limits) {
    OIIO::attribute("threads", 1);
    OIIO::attribute("limits:imagesize_MB", 5000);
    const Result<std::vector<fs::path>> files = texture::volume_files(source);
    if (!files) return files.error();
    return write_volume(source, out, options, limits,
                        [&] { return open_any(*files, options, limits); });
}

}  // namespace openfab::tools
