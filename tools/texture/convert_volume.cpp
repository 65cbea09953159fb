// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/convert_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <string_view>

#include "base/input_file.h"
#include "base/text.h"
#include "texture/meta_header.h"
#include "texture/xdmf_grid.h"
#include "texture/zarr_store.h"
#include "tools/texture/decoder.h"
#include "tools/texture/guarded.h"
#include "tools/texture/hdf5_kind.h"
#include "tools/texture/messages.h"
#include "tools/texture/print_volume.h"
#include "tools/texture/scans.h"
#include "tools/texture/slice_names.h"
#include "tools/texture/still_image.h"
#include "tools/texture/tiff_stack.h"
#include "tools/texture/volume_reader.h"
#include "tools/texture/vtk_file.h"
#include "tools/texture/write_volume.h"
#include "tools/texture/xdmf_reader.h"
#include "tools/texture/zarr_volume.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Slices that are pictures.
class StackReader final : public VolumeReader {
  public:
    StackReader(std::vector<fs::path> files, const texture::VolumeOptions& options,
                int64_t memory_bytes)
        : files_(std::move(files)),
          options_(options.image),
          takes_nan_(options.outside.has_value()),
          memory_bytes_(memory_bytes) {}

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
            return user_error(fmt::format(messages::kPictureChannels, spec_.nchannels,
                                          fmt::join(spec_.channelnames, ", ")));
        if (!image_->left_out().empty())
            tell(fmt::format(messages::kChannelsLeftOut, files_[0].filename().string(),
                             fmt::join(image_->left_out(), ", ")));
        channels = options_.luminance ? 1 : image_->color().inks ? 3 : spec_.nchannels;
        one_field = no_lengths = true;
        no_nan = !spec_.format.is_floating_point();
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
                if (!decoder_->pixel(pixel, row)) {
                    if (!takes_nan_ || std::any_of(pixel, pixel + spec_.nchannels,
                                                   [](float v) { return std::isinf(v); }))
                        return user_error(fmt::format(messages::kPixelOfSliceNotFinite, x, y, z));
                    // What stands for NaN is known to who writes the pyramid.
                    std::fill_n(row, channels, std::numeric_limits<float>::quiet_NaN());
                }
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
        if (files_.size() > 1 && image_->has_more())
            return named(file, user_error(messages::kPagesAmongPictures));
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
    bool takes_nan_;
    int64_t memory_bytes_;
    std::unique_ptr<StillImage> image_;
    OIIO::ImageSpec spec_;
    std::optional<Decoder> decoder_;
};

/// Refuses by name what is a volume and is not read: a picture's error would say nothing of it.
Result<void> refuse_others(const fs::path& file, const InputFile& opened, const std::string& kind,
                           std::string_view begin) {
    if (kind == ".nii" || lower_ascii(file.filename().string()).ends_with(".nii.gz"))
        return user_error(messages::kNotNifti);
    constexpr std::array<std::string_view, 2> kAnalyze{{{"\x5c\x01\0\0", 4}, {"\0\0\x01\x5c", 4}}};
    if (kind == ".hdr" && (begin.starts_with(kAnalyze[0]) || begin.starts_with(kAnalyze[1])))
        return user_error(messages::kAnalyze75, messages::kAnalyze75Help);
    if (kind == ".img") return user_error(messages::kOnlyNumbers, messages::kOnlyNumbersHdrHelp);
    if (kind == ".raw" || kind == ".zraw" || kind == ".bin")
        return user_error(messages::kOnlyNumbers, messages::kOnlyNumbersRawHelp);
    if (begin.starts_with("\x1f\x8b")) return user_error(messages::kIsGzip, messages::kIsGzipHelp);
    if (kind == ".npz")
        return user_error(messages::kArchiveOfArrays, messages::kArchiveOfArraysHelp);
    if (begin.starts_with("MATLAB 5.0") || (kind == ".mat" && !is_hdf5(opened)))
        return user_error(messages::kIsMatlab, messages::kIsMatlabHelp);
    if (is_hdf5(opened) || kind == ".h5" || kind == ".hdf5" || kind == ".hdf" || kind == ".nc" ||
        kind == ".mnc")
        return user_error(messages::kIsHdf5, messages::kIsHdf5Help);
    for (const char* parallel :
         {".pvti", ".pvtr", ".pvts", ".pvtu", ".vtm", ".vtmb", ".vth", ".vthb", ".pvd"}) {
        if (kind == parallel) return user_error(messages::kPartsOfGrid, messages::kPartsOfGridHelp);
    }
    if (kind == ".mrc") return user_error(messages::kNotMrc);
    if (kind == ".vtp") return user_error(messages::kIsASurface, messages::kIsASurfaceHelp);
    for (const char* other : {".mgz", ".mgh", ".htg", ".exo", ".e", ".msh", ".inp", ".vol"}) {
        if (kind == other)
            return user_error(fmt::format(messages::kVolumesNotRead, kind),
                              messages::kVolumesNotReadHelp);
    }
    return {};
}

/// Whether a PNG holds indices into colours.
bool is_palette_png(const fs::path& path) {
    const Result<InputFile> file = InputFile::open(path);
    std::array<char, 26> head{};  // up to the kind of colour in IHDR
    if (!file) return false;
    const Result<size_t> got = file->read(0, head.data(), head.size());
    constexpr char kPalette = 3;
    return got && *got == head.size() && head[1] == 'P' && head[2] == 'N' && head[25] == kPalette;
}

/// Slices as pictures, or as pages of TIFFs.
MadeReader open_slices(const std::vector<fs::path>& files, const texture::VolumeOptions& options,
                       const texture::ReadLimits& limits) {
    if (is_palette_png(files.front()))
        tell(fmt::format(messages::kPaletteAsColours, files.front().filename().string()));
    if (are_tiffs(files)) {
        MadeReader pages = open_tiff_stack(files, options, limits);
        if (!pages || *pages != nullptr) return pages;
    } else if (Result<void> named = check_slice_names(files, false); !named) {
        return named.error();
    }
    return open_stack(files, options, limits);
}

/// Notes that the file holds one field.
MadeReader of_one_field(MadeReader reader) {
    if (reader) (*reader)->one_field = true;
    return reader;
}

/// Notes that the file holds an array or a table of numbers in their order.
MadeReader of_plain_numbers(MadeReader reader) {
    if (reader) (*reader)->one_field = (*reader)->no_lengths = true;
    return reader;
}

/// A store of Zarr. All of a print by OpenFab is read by its list of shards: only that tells void from what is missing.
MadeReader open_store(const fs::path& file, const texture::VolumeOptions& options,
                      const texture::ReadLimits& limits) {
    Result<texture::ZarrVolume> volume = texture::read_zarr_store(file, options, limits);
    if (!volume) return volume.error();
    if (volume->print && options.field.empty() && options.pitch_mm == 0)
        return of_plain_numbers(open_print(file.parent_path(), limits));
    return open_zarr(file, std::move(*volume), limits);
}

/// By signature; only colour tables are recognized by their names.
MadeReader open_any(const std::vector<fs::path>& files, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits) {
    if (files[0].filename() == texture::kPrintManifest)
        return of_plain_numbers(open_print(files[0].parent_path(), limits));
    if (files.size() != 1) return open_slices(files, options, limits);
    if (texture::is_zarr_metadata(files[0])) return open_store(files[0], options, limits);
    const Result<InputFile> file = InputFile::open(files[0]);
    if (!file) return file.error();
    std::array<char, 256> head{};
    const Result<size_t> got = file->read(0, head.data(), head.size());
    if (!got) return got.error();
    const std::string_view begin(head.data(), *got);
    if (is_print(files[0], begin)) return of_plain_numbers(open_print(files[0], limits));
    if (begin.starts_with("NRRD")) return of_one_field(open_nrrd(files[0], options, limits));
    const std::string kind = lower_ascii(files[0].extension().string());
    if (begin.starts_with("\x93NUMPY")) return of_plain_numbers(open_npy(files[0], limits));
    if (kind == ".cube") return of_plain_numbers(open_cube(files[0], limits));
    if (is_nifti_file(files[0])) return open_nifti(files[0], options, limits);
    if (texture::is_meta_image(files[0])) return of_one_field(open_meta(files[0], options, limits));
    if (begin.starts_with(kLegacyVtk)) return open_vtk(files[0], options, limits);
    for (const char* name : {".vti", ".vtr", ".vts", ".vtu", ".vtk"}) {
        if (kind == name) return open_vtk(files[0], options, limits);
    }
    if (texture::is_xdmf(files[0])) return open_xdmf(files[0], options, limits);
    if (is_mrc(begin)) return of_one_field(open_mrc(files[0], options, limits));
    if (kind == ".nrrd" || kind == ".nhdr") return user_error(messages::kNotNrrd);
    if (kind == ".npy") return user_error(messages::kNotNpy);
    if (Result<void> known = refuse_others(files[0], *file, kind, begin); !known)
        return known.error();
    return open_slices(files, options, limits);
}

}  // namespace

MadeReader open_stack(const std::vector<fs::path>& files, const texture::VolumeOptions& options,
                      const texture::ReadLimits& limits) {
    auto reader = std::make_unique<StackReader>(files, options, limits.memory_bytes);
    if (Result<void> opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

Result<void> make_volume_file(const std::filesystem::path& source, const std::filesystem::path& out,
                              const texture::VolumeOptions& options,
                              const texture::ReadLimits& limits) {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
    OIIO::attribute("limits:imagesize_MB", 5000);
    const Result<std::vector<fs::path>> files = texture::volume_files(source);
    if (!files) return files.error();
    return write_volume(source, out, options, limits,
                        [&] { return open_any(*files, options, limits); });
}

}  // namespace openfab::tools
