// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "base/input_file.h"
#include "base/scan_number.h"
#include "tools/texture/array_numbers.h"
#include "tools/texture/decoder.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/picture_format.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/slice_names.h"
#include "tools/texture/tiff_image.h"
#include "tools/texture/tiff_makers.h"
#include "tools/texture/tiff_pages.h"
#include "tools/texture/tiff_series.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Of a hyperstack's channels and slices together.
constexpr size_t kMostPages = 65536;

/// Where a slice lies.
struct Plane {
    size_t file = 0;
    uint64_t directory = 0;
    int32_t layer = 0;  ///< of a page that is a volume
    int64_t shift = 0;  ///< of a page without a directory of its own
};

/// Finds the planes of all files.
class TiffPlanes {
  public:
    TiffPlanes(const std::vector<fs::path>& files, const texture::VolumeOptions& options,
               const texture::ReadLimits& limits)
        : files_(files), options_(options), limits_(limits) {}

    std::vector<Plane> planes;
    std::optional<std::array<double, 3>> spacing;
    TiffDirectory first;

    Result<void> find() {
        for (size_t file = 0; file < files_.size() && !has_all_; ++file) {
            if (Result<void> added = add(file); !added) {
                if (files_.size() == 1) return added;
                return with_context(added.error(), files_[file].filename().string() + ": ");
            }
        }
        return {};
    }

    /// Whether the first file says where all planes are.
    bool are_listed() const { return has_all_; }

  private:
    Result<void> add(size_t index) {
        const Result<InputFile> file = InputFile::open(files_[index]);
        if (!file) return file.error();
        const Result<std::vector<uint64_t>> pages = pages_of(*file, index == 0);
        if (!pages) return pages.error();
        Result<std::unique_ptr<TiffImage>> image =
            TiffImage::open(*file, pages->front(), limits_.memory_bytes);
        if (!image) return image.error();
        const TiffDirectory& page = (*image)->directory();
        const std::string name = files_[index].filename().string();
        const Result<TiffSeries> series =
            read_tiff_series(page, static_cast<int64_t>(pages->size()), name);
        if (!series) return series.error();
        if (Result<void> slices = check_pages(*file, page, *pages); !slices) return slices.error();
        const Result<int64_t> channel = choose(*series);
        if (!channel) return channel.error();
        if (index == 0) {
            first = page;
            set_spacing(*series);
            for (const std::string& note : series->notes)
                tell(name + ": " + note);
        }
        if (!series->places.empty()) return add_listed(index, *series, *channel, *pages);
        const bool of_one_directory = pages->size() == 1 && series->planes() > 1;
        if (of_one_directory) return add_shifted(index, *file, **image, *series, *channel);
        for (int64_t z = 0; z < series->slices; ++z) {
            for (int32_t layer = 0; layer < page.depth; ++layer) {
                planes.push_back(
                    {index, (*pages)[static_cast<size_t>(series->page(*channel, z))], layer, 0});
            }
        }
        return {};
    }

    /// Fails where what a program wrote with each page says that they are not slices.
    Result<void> check_pages(const InputFile& file, const TiffDirectory& page,
                             const std::vector<uint64_t>& pages) const {
        const bool has_list = page.description.starts_with("ImageJ=") ||
                              page.description.find("<OME") != std::string::npos;
        if (page.micro_manager.empty() || has_list || pages.size() < 2) return {};
        const Result<std::unique_ptr<TiffImage>> last =
            TiffImage::open(file, pages.back(), limits_.memory_bytes);
        if (!last) return last.error();
        return check_micro_manager((*last)->directory(), static_cast<int64_t>(pages.size()));
    }

    /// Lists the pages, without smaller copies of others.
    static Result<std::vector<uint64_t>> pages_of(const InputFile& file, bool tells) {
        bool is_cut = false;
        std::vector<uint64_t> all = tiff_pages(file, kMostPages + 1, &is_cut);
        if (all.size() > kMostPages)
            return user_error(fmt::format(messages::kTooManyPages, kMostPages));
        if (is_cut) return user_error(fmt::format(messages::kTiffCut, all.size()));
        if (all.empty()) return user_error(messages::kPictureDamaged);
        std::vector<uint64_t> whole;
        std::copy_if(all.begin(), all.end(), std::back_inserter(whole),
                     [&](uint64_t page) { return !is_reduced_page(file, page); });
        if (whole.empty() || whole.size() == all.size()) return all;
        if (tells) tell(fmt::format(messages::kReducedLeftOut, all.size() - whole.size()));
        return whole;
    }

    Result<int64_t> choose(const TiffSeries& series) const {
        if (series.frames > 1)
            return user_error(fmt::format(messages::kFramesInTime, series.frames),
                              messages::kFramesInTimeHelp);
        if (series.channels == 1) {
            if (options_.field.empty() || options_.field == "1" ||
                (!series.names.empty() && series.names[0] == options_.field))
                return int64_t{0};
            return user_error(fmt::format(messages::kOneVolume, options_.field));
        }
        // By its number, too, where it has a name.
        int64_t number = 0;
        const std::string& wanted = options_.field;
        const bool named =
            std::find(series.names.begin(), series.names.end(), wanted) != series.names.end();
        if (!named && !wanted.empty() && scan_integer(wanted, 1, series.channels, &number).empty())
            return number - 1;
        const Result<size_t> picked = pick_field(series.names, wanted);
        if (!picked) return picked.error();
        return static_cast<int64_t>(*picked);
    }

    void set_spacing(const TiffSeries& series) {
        spacing = series.spacing_mm;
        if (!spacing || options_.unit.empty()) return;
        for (double& side : *spacing)
            side *= unit_mm(options_) / series.unit_mm;
    }

    /// Planes that lie in pages of this file, or of another of the files.
    Result<void> add_listed(size_t index, const TiffSeries& series, int64_t channel,
                            const std::vector<uint64_t>& own) {
        std::map<std::string, std::pair<size_t, std::vector<uint64_t>>> others;
        for (int64_t z = 0; z < series.slices; ++z) {
            const TiffSeries::Place& place =
                series.places[static_cast<size_t>(z * series.channels + channel)];
            if (place.file.empty()) {
                planes.push_back({index, own[static_cast<size_t>(place.page)], 0, 0});
                continue;
            }
            has_all_ = true;
            auto found = others.find(place.file);
            if (found == others.end()) {
                Result<std::pair<size_t, std::vector<uint64_t>>> other = other_file(place.file);
                if (!other) return other.error();
                found = others.emplace(place.file, std::move(*other)).first;
            }
            const auto& [file, pages] = found->second;
            if (place.page >= static_cast<int64_t>(pages.size()))
                return user_error(
                    fmt::format(messages::kPagesContradict, place.page + 1, pages.size()));
            planes.push_back({file, pages[static_cast<size_t>(place.page)], 0, 0});
        }
        return {};
    }

    Result<std::pair<size_t, std::vector<uint64_t>>> other_file(const std::string& name) const {
        const auto found = std::find_if(files_.begin(), files_.end(), [&](const fs::path& file) {
            return file.filename().string() == name;
        });
        if (found == files_.end())
            return user_error(fmt::format(messages::kPlanesInOtherFile, name),
                              messages::kPlanesInOtherFileHelp);
        const Result<InputFile> file = InputFile::open(*found);
        if (!file) return file.error();
        Result<std::vector<uint64_t>> pages = pages_of(*file, false);
        if (!pages) return pages.error();
        return std::pair(static_cast<size_t>(found - files_.begin()), std::move(*pages));
    }

    /// Planes behind each other in the file, of which only the first has a directory.
    Result<void> add_shifted(size_t index, const InputFile& file, const TiffImage& image,
                             const TiffSeries& series, int64_t channel) {
        const TiffDirectory& page = image.directory();
        const int64_t begin = image.contiguous_begin();
        const int64_t bytes = int64_t{page.width} * page.height * page.samples * page.bits / 8;
        if (begin < 0 || page.bits % 8 != 0 || page.depth > 1)
            return user_error(fmt::format(messages::kPagesContradict, series.planes(), 1));
        if (bytes > (file.bytes() - begin) / series.planes())
            return user_error(messages::kCutShort);
        const std::vector<uint64_t> own = tiff_pages(file, 1);
        for (int64_t z = 0; z < series.slices; ++z)
            planes.push_back({index, own.front(), 0, series.page(channel, z) * bytes});
        return {};
    }

    const std::vector<fs::path>& files_;
    const texture::VolumeOptions& options_;
    const texture::ReadLimits& limits_;
    bool has_all_ = false;
};

class TiffStack final : public VolumeReader {
  public:
    TiffStack(std::vector<fs::path> files, const texture::VolumeOptions& options,
              int64_t memory_bytes)
        : files_(std::move(files)), options_(options), memory_bytes_(memory_bytes) {}

    /// Takes the planes; `first` is what the first of them says of itself.
    Result<void> open(std::vector<Plane> planes, const TiffDirectory& first) {
        planes_ = std::move(planes);
        first_ = first;
        constexpr size_t kMostSlices = 16384;
        if (planes_.size() > kMostSlices)
            return user_error(fmt::format(messages::kSideNotPossible, planes_.size()));
        size = {first.width, first.height, static_cast<int32_t>(planes_.size())};
        if (first.samples > 4)
            return user_error(fmt::format(messages::kImageChannels, first.samples));
        texture::ImageOptions image = options_.image;
        channels = image.luminance ? 1 : first.samples;
        // Slices are mostly measurements; only colour images count as pictures.
        const bool is_byte = first.bits == 8 && first.kind == TiffDirectory::Kind::kUnsigned;
        const bool colour = is_byte && first.samples >= 3 && first.is_colour();
        if (image.space == "auto") image.space = colour ? "srgb" : "linear";
        if (image.space == "srgb" || image.luminance) {
            const OIIO::ImageSpec spec(first.width, first.height, first.samples,
                                       is_byte ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT);
            decoder_.emplace(spec, FileColor(), image, Decoder::Alpha::kNumber);
        }
        return {};
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const Plane& plane = planes_[static_cast<size_t>(z)];
        Result<void> read = select(plane, z);
        if (read) {
            read = image_->each_row(plane.layer, TiffImage::Scale::kVolume, plane.shift,
                                    [&](int32_t y, const float* row) -> Result<void> {
                                        Result<void> taken =
                                            take(row, y, z, out + y * row_floats());
                                        wrote(4 * row_floats());
                                        return taken;
                                    });
        }
        if (!read && files_.size() > 1)
            return with_context(read.error(), files_[plane.file].filename().string() + ": ");
        rounded = rounded || (read && image_->has_rounded());
        return read;
    }

  private:
    Result<void> take(const float* row, int32_t y, int32_t z, float* out) const {
        for (int32_t x = 0; x < size.x; ++x, row += first_.samples, out += channels) {
            bool fine = true;
            if (decoder_) {
                fine = decoder_->pixel(row, out);
            } else {
                for (int32_t c = 0; c < channels; ++c) {
                    out[c] = row[c];
                    // What stands for NaN is known to who writes the pyramid.
                    fine =
                        fine && (std::isfinite(row[c]) || (options_.outside && std::isnan(row[c])));
                }
            }
            if (!fine) return user_error(fmt::format(messages::kPixelOfSliceNotFinite, x, y, z));
        }
        return {};
    }

    /// Makes the plane's page the current one.
    Result<void> select(const Plane& plane, int32_t z) {
        const bool same_file = file_ && current_.file == plane.file;
        if (same_file && image_ && current_.directory == plane.directory) return {};
        image_.reset();
        if (!same_file) {
            Result<InputFile> file = InputFile::open(files_[plane.file]);
            if (!file) return file.error();
            file_ = std::make_unique<InputFile>(std::move(*file));
        }
        Result<std::unique_ptr<TiffImage>> image =
            TiffImage::open(*file_, plane.directory, memory_bytes_);
        if (!image) return image.error();
        image_ = std::move(*image);
        current_ = plane;
        const TiffDirectory& page = image_->directory();
        if (page.width != size.x || page.height != size.y || page.samples != first_.samples)
            return user_error(fmt::format(messages::kSliceOfOtherSize, z, page.width, page.height,
                                          page.samples, size.x, size.y, first_.samples));
        const auto is_fraction = [](const TiffDirectory& of) {
            return of.kind == TiffDirectory::Kind::kUnsigned && of.bits <= 16;
        };
        const bool alike =
            is_fraction(page) == is_fraction(first_) && page.photometric == first_.photometric;
        return alike ? Result<void>() : user_error(fmt::format(messages::kSliceOfOtherKind, z));
    }

    std::vector<fs::path> files_;
    texture::VolumeOptions options_;
    int64_t memory_bytes_;
    std::vector<Plane> planes_;
    TiffDirectory first_;
    std::optional<Decoder> decoder_;
    std::unique_ptr<InputFile> file_;
    std::unique_ptr<TiffImage> image_;
    Plane current_;
};

/// Whether the planes are all pages of the file, in their order.
bool are_all_pages(const fs::path& path, const std::vector<Plane>& planes) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return false;
    const std::vector<uint64_t> pages = tiff_pages(*file, kMostPages);
    return std::equal(planes.begin(), planes.end(), pages.begin(), pages.end(),
                      [](const Plane& plane, uint64_t page) {
                          return plane.directory == page && plane.layer == 0 && plane.shift == 0;
                      });
}

}  // namespace

bool are_tiffs(const std::vector<fs::path>& files) {
    return std::all_of(files.begin(), files.end(), [](const fs::path& path) {
        const Result<InputFile> file = InputFile::open(path);
        if (!file) return false;
        const Result<PictureFormat> format = picture_format(*file);
        return format && format->reader == "tiff";
    });
}

MadeReader open_tiff_stack(const std::vector<fs::path>& files,
                           const texture::VolumeOptions& options,
                           const texture::ReadLimits& limits) {
    TiffPlanes found(files, options, limits);
    if (Result<void> done = found.find(); !done) return done.error();
    if (!found.are_listed()) {
        if (Result<void> named = check_slice_names(files, found.planes.size() > files.size());
            !named)
            return named.error();
    }
    const TiffDirectory& first = found.first;
    const bool indices = first.is_palette() && options.image.space != "srgb";
    if (!first.is_plain() && !indices) {
        // They are read as pictures, page by page.
        if (files.size() == 1 && !are_all_pages(files.front(), found.planes))
            return user_error(messages::kColoursOfSeries, messages::kColoursOfSeriesHelp);
        return std::unique_ptr<VolumeReader>();
    }
    constexpr int kWhiteIsLeast = 0;
    if (indices) {
        tell(fmt::format(messages::kPaletteAsNumbers, files.front().filename().string(),
                         (uint32_t{1} << first.bits) - 1));
    }
    if (first.photometric == kWhiteIsLeast)
        tell(fmt::format(messages::kWhiteIsLeast, files.front().filename().string()));
    auto reader = std::make_unique<TiffStack>(files, options, limits.memory_bytes);
    if (Result<void> opened = reader->open(std::move(found.planes), first); !opened)
        return opened.error();
    reader->spacing = found.spacing;
    reader->no_lengths = !found.spacing;
    reader->no_nan = first.kind != TiffDirectory::Kind::kFloat;
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
