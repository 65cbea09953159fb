// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/still_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "base/units.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/convert.h"
#include "tools/texture/embedded_profile.h"
#include "tools/texture/exif.h"
#include "tools/texture/exr_header.h"
#include "tools/texture/messages.h"
#include "tools/texture/picture_format.h"

namespace openfab::tools {
namespace {

namespace fs = std::filesystem;

/// TIFF's photometric interpretation of inks, and how many there are.
constexpr int kInks = 5, kFourInks = 4;
/// Rows that are read at once, unless the file dictates more.
constexpr int kRows = 64;
/// The most rows in one OpenEXR chunk.
constexpr int kExrRows = 256;

bool is_interlaced(const InputFile& png) {
    constexpr int64_t kPlace = 28;  // of the interlace method in IHDR, which comes first
    uint8_t method = 0;
    const Result<size_t> got = png.read(kPlace, &method, 1);
    return got && *got == 1 && method != 0;
}

/// Returns the channels of a picture among more than four: red, green, blue and alpha; else none.
std::vector<int> colour_channels(const OIIO::ImageSpec& spec) {
    std::vector<int> out;
    for (const char* name : {"R", "G", "B", "A"}) {
        const int channel = spec.channelindex(name);
        if (channel >= 0) {
            out.push_back(channel);
        } else if (*name != 'A') {
            return {};
        }
    }
    return out;
}

}  // namespace

Result<std::unique_ptr<StillImage>> StillImage::open(const fs::path& file, int64_t memory_bytes,
                                                     bool guarded) {
    Result<InputFile> opened = InputFile::open(file);
    if (!opened) return opened.error();
    const Result<PictureFormat> format = picture_format(*opened);
    if (!format) return format.error();
    const bool too_fragile = format->fragile && !guarded;
    if (format->reader.empty() || too_fragile)
        return user_error(fmt::format(messages::kNotASupportedPicture,
                                      guarded ? kStillFormats : kHardenedFormats));
    if (Result<void> fine = check_memory(2 * format->at_once, memory_bytes); !fine)
        return fine.error();
    std::unique_ptr<StillImage> image(new StillImage(std::move(*opened), memory_bytes));
    image->shown_ = file.filename().string();
    image->format_ = format->reader;
    image->bare_alpha_ = format->bare_alpha;
    if (format->plain_bits) {
        Result<std::vector<char>> bits = packed_bits(image->file_);
        if (!bits) return bits.error();
        image->bits_ = std::move(*bits);
        image->bits_file_ = std::make_unique<OIIO::Filesystem::IOMemReader>(image->bits_.data(),
                                                                            image->bits_.size());
    }
    if (Result<void> opened = image->open_input(); !opened) return opened.error();
    return image;
}

Result<void> StillImage::open_input() {
    reads_inks_ = false;
    stores_inks_ = format_ == "jpeg" && jpeg_components(file_) == kFourInks;
    input_ = OIIO::ImageInput::create(format_);
    if (input_ == nullptr) return trouble(OIIO::geterror());
    if (page_file_ != nullptr) input_->set_ioproxy(page_file_.get());
    if (bits_file_ != nullptr) input_->set_ioproxy(bits_file_.get());
    OIIO::ImageSpec config, spec;
    // For a fablet alpha is just another channel; colours must not be premultiplied.
    config.attribute("oiio:UnassociatedAlpha", 1);
    bool opened = input_->open(file_.name(), spec, config);
    if (format_ == "tiff" && (!opened || lab_of(spec) != Lab::kNone)) {
        // The library would convert Lab to a screen's colours, by eight bits, or not read it.
        const std::string reason = opened ? "" : input_->geterror();
        config.attribute("oiio:RawColor", 1);
        opened = input_->open(file_.name(), spec, config) && lab_of(spec) != Lab::kNone;
        if (!opened) return trouble(reason);
    }
    if (!opened) return not_opened();
    subimage_ = 0;
    if (Result<void> fine = fits(); !fine) return fine;
    if (Result<void> framed = frame(); !framed) return framed;
    if (stores_inks_) return open_jpeg();
    return format_ == "tiff" ? open_tiff() : Result<void>();
}

Result<void> StillImage::open_jpeg() {
    Result<std::unique_ptr<JpegInks>> opened = JpegInks::open(file_, memory_bytes_);
    if (!opened) return opened.error();
    if (!knows_inks()) return {};
    jpeg_ = std::move(*opened);
    read_inks();
    return {};
}

void StillImage::read_inks() {
    reads_inks_ = true;
    spec_.nchannels = kFourInks;
    spec_.channelnames = {"C", "M", "Y", "K"};
    spec_.alpha_channel = -1;
}

Result<void> StillImage::open_tiff() {
    const std::vector<uint64_t> first = tiff_pages(file_, 1);
    if (first.empty()) return user_error(messages::kPictureDamaged);
    const uint64_t directory = page_file_ == nullptr ? first.front() : page_directory_;
    Result<std::unique_ptr<TiffImage>> opened = TiffImage::open(file_, directory, memory_bytes_);
    if (!opened) return opened.error();
    if (Result<void> whole = (*opened)->check_places(); !whole) return whole;
    const TiffDirectory& page = (*opened)->directory();
    // What is stored in another way than as light stays OpenImageIO's.
    constexpr int kBlackIsLeast = 1, kRgb = 2;
    const bool light = page.photometric == kBlackIsLeast || page.photometric == kRgb;
    const bool bytes = page.bits == 8 || page.bits == 16 || page.bits == 32 || page.bits == 64;
    stores_inks_ = page.photometric == kInks;
    if (stores_inks_ && page.samples == kFourInks && (page.bits == 8 || page.bits == 16) &&
        knows_inks())
        read_inks();
    const bool same = light && bytes && page.samples == input_->spec().nchannels;
    if (!same && !reads_inks_) return (*opened)->check_chunks();
    tiff_ = std::move(*opened);
    return {};
}

bool StillImage::knows_inks() const {
    const std::vector<uint8_t> profile = color_of(file_, format_, input_->spec()).profile;
    return !profile.empty() && EmbeddedProfile::find(profile, kFourInks).other != nullptr;
}

FileColor StillImage::color() const {
    FileColor color = color_of(file_, format_, spec());
    color.bare_alpha = bare_alpha_;
    color.straight_alpha = format_ == "bmp";
    color.inks = reads_inks_;
    if (stores_inks_ && !reads_inks_)
        color.note =
            color.profile.empty() ? messages::kInksWithoutProfile : messages::kInksProfileUnused;
    return color;
}

int StillImage::pages() {
    constexpr int kMost = kMostPages + 1;
    if (format_ == "tiff") {
        page_offsets_ = tiff_pages(file_, kMost);
        return std::max(static_cast<int>(page_offsets_.size()), 1);
    }
    int pages = 1;
    while (pages < kMost && input_->seek_subimage(pages, 0))
        ++pages;
    (void)input_->geterror();
    return pages;
}

bool StillImage::has_more() {
    if (format_ == "tiff") return tiff_pages(file_, 2).size() > 1;
    if (format_ != "openexr" && format_ != "gif" && format_ != "webp") return false;
    const bool more = input_->seek_subimage(1, 0);
    (void)input_->geterror();
    return more;
}

Result<void> StillImage::go_to(int page) {
    const bool first = page == 0 && page_file_ == nullptr;
    if (format_ == "tiff" && !first) {
        input_.reset();  // before its file
        tiff_.reset();
        page_directory_ = page_offsets_[page];
        page_file_ = std::make_unique<TiffPage>(file_, page_directory_);
        return open_input();
    }
    if (!input_->seek_subimage(page, 0)) return trouble(input_->geterror());
    subimage_ = page;
    if (Result<void> fine = fits(); !fine) return fine;
    return frame();
}

/// Programs that render crop a picture's data to what is not black, and add channels of their own, such as depth.
Result<void> StillImage::frame() {
    spec_ = input_->spec();
    picked_.clear();
    left_out_.clear();
    if (format_ != "openexr") return {};
    const OIIO::ImageSpec& stored = input_->spec();
    spec_.x = stored.full_x, spec_.y = stored.full_y;
    spec_.width = stored.full_width, spec_.height = stored.full_height;
    constexpr int kMost = 4;
    if (stored.nchannels > kMost) picked_ = colour_channels(stored);
    // Of an object's name light cannot be made.
    for (int c = 0; c < stored.nchannels; ++c) {
        const bool taken = picked_.empty() || std::ranges::find(picked_, c) != picked_.end();
        if (taken && stored.channelformat(c) == OIIO::TypeDesc::UINT32)
            return user_error(fmt::format(messages::kExrWholeNumbers, stored.channel_name(c)),
                              messages::kExrWholeNumbersHelp);
    }
    if (picked_.empty()) return {};
    spec_.channelnames.clear();
    for (int c = 0; c < stored.nchannels; ++c) {
        const bool taken = std::find(picked_.begin(), picked_.end(), c) != picked_.end();
        if (!taken) left_out_.push_back(stored.channel_name(c));
    }
    for (const int c : picked_)
        spec_.channelnames.push_back(stored.channel_name(c));
    spec_.nchannels = static_cast<int>(picked_.size());
    spec_.alpha_channel = picked_.size() == kMost ? kMost - 1 : -1;
    spec_.channelformats.clear();
    return {};
}

int StillImage::band_rows() const {
    const OIIO::ImageSpec& s = input_->spec();
    return std::min(s.height, s.tile_height > 0 ? s.tile_height : kRows);
}

Result<void> StillImage::fits() const {
    const OIIO::ImageSpec& s = input_->spec();
    if (s.width < 1 || s.height < 1 || s.full_width < 1 || s.full_height < 1)
        return user_error(messages::kPictureEmpty);
    if (s.deep) return user_error(messages::kDeepImage);
    if (std::string_view(s.get_string_attribute("textureformat")).starts_with("CubeFace"))
        return user_error(messages::kCubeOfFaces);
    if (s.depth > 1) return user_error(messages::kIsAVolume);
    const auto pixels = static_cast<double>(s.width) * s.height;
    const double row = static_cast<double>(s.width) * s.nchannels;
    const auto stored = static_cast<double>(s.format.size());
    // Twice the stored form during decompression, then floats.
    double rows = band_rows();
    double whole = 0;
    if (format_ == "tiff") {
        rows = std::max(rows, static_cast<double>(s.get_int_attribute("tiff:RowsPerStrip", 0)));
        rows = std::min(rows, static_cast<double>(s.height));
        whole = 4 * pixels;  // unusual formats are decoded to four bytes a pixel
        // Pages are not mapped: strips are read compressed, and libtiff limits them to this size,
        // whatever the directory says.
        constexpr double kLoosest = 10, kLeast = 1 << 20;
        if (page_file_ != nullptr) {
            whole += std::min(static_cast<double>(file_.bytes()),
                              std::max(kLoosest * rows * row * stored, kLeast));
        }
    } else if (format_ == "openexr") {
        rows =
            std::min(std::max(rows, static_cast<double>(kExrRows)), static_cast<double>(s.height));
    } else if (format_ == "png" && is_interlaced(file_)) {
        whole = pixels * s.nchannels * stored;
    } else if (format_ == "jpeg") {
        whole = pixels * s.nchannels * 2;
    } else if (format_ == "pnm") {
        whole = static_cast<double>(file_.bytes());
    } else if (format_ == "bmp" || format_ == "targa" || format_ == "gif" || format_ == "webp") {
        whole = 4 * pixels;
    }
    const double needed = 2 * (whole + rows * row * 2 * stored + band_rows() * row * 4);
    constexpr double kMost = 1e18;
    return check_memory(static_cast<int64_t>(std::min(needed, kMost)), memory_bytes_);
}

Result<void> StillImage::each_row(const std::function<Result<void>(int y, const float* row)>& use) {
    if (jpeg_ != nullptr) return jpeg_->each_row(use);
    if (tiff_ != nullptr) return tiff_->each_row(0, TiffImage::Scale::kPicture, 0, use);
    const OIIO::ImageSpec& s = input_->spec();
    const bool whole = spec_.x == s.x && spec_.y == s.y && spec_.width == s.width &&
                       spec_.height == s.height && picked_.empty();
    if (whole) return each_stored_row(use);
    const auto channels = static_cast<size_t>(spec_.nchannels);
    const auto stored = static_cast<size_t>(s.nchannels);
    std::vector<float> row(static_cast<size_t>(spec_.width) * channels);
    int next = 0;  // of the picture's rows
    const auto empty_until = [&](int end) -> Result<void> {
        std::fill(row.begin(), row.end(), 0.0F);
        for (; next < end; ++next) {
            if (Result<void> used = use(next, row.data()); !used) return used;
        }
        return {};
    };
    Result<void> done = each_stored_row([&](int y, const float* data) -> Result<void> {
        const int at = s.y + y - spec_.y;
        if (at < 0 || at >= spec_.height) return {};
        if (Result<void> used = empty_until(at); !used) return used;
        std::fill(row.begin(), row.end(), 0.0F);
        const int begin = std::max(s.x, spec_.x);
        const int end = std::min(s.x + s.width, spec_.x + spec_.width);
        for (int x = begin; x < end; ++x) {
            const float* const from = data + static_cast<size_t>(x - s.x) * stored;
            float* const to = row.data() + static_cast<size_t>(x - spec_.x) * channels;
            for (size_t c = 0; c < channels; ++c)
                to[c] = from[picked_.empty() ? c : static_cast<size_t>(picked_[c])];
        }
        ++next;
        return use(at, row.data());
    });
    return done ? empty_until(spec_.height) : done;
}

Result<void> StillImage::each_stored_row(
    const std::function<Result<void>(int y, const float* row)>& use) {
    const OIIO::ImageSpec& s = input_->spec();
    const auto row_floats = static_cast<size_t>(s.width) * static_cast<size_t>(s.nchannels);
    const int step = band_rows();
    std::vector<float> rows(row_floats * static_cast<size_t>(step));
    // As they are stored: for numbers that it converts the library takes memory of its own, for 256 lines at least.
    const size_t stored_row = s.scanline_bytes(true);
    std::vector<std::byte> stored(s.tile_width > 0 ? 0 : stored_row * static_cast<size_t>(step));
    const auto read_lines = [&](int begin, int end) {
        if (!input_->read_scanlines(subimage_, 0, s.y + begin, s.y + end, s.z, 0, s.nchannels,
                                    OIIO::TypeDesc::UNKNOWN, stored.data()))
            return false;
        const auto pixel = static_cast<OIIO::stride_t>(s.pixel_bytes(true));
        const auto convert = [&](int channels, OIIO::TypeDesc type, size_t from, int to) {
            constexpr OIIO::stride_t kFloat = sizeof(float);
            return OIIO::convert_image(channels, s.width, end - begin, 1, stored.data() + from,
                                       type, pixel, static_cast<OIIO::stride_t>(stored_row),
                                       OIIO::AutoStride, rows.data() + to, OIIO::TypeDesc::FLOAT,
                                       kFloat * s.nchannels, kFloat * s.nchannels * s.width,
                                       OIIO::AutoStride);
        };
        if (s.channelformats.empty()) return convert(s.nchannels, s.format, 0, 0);
        size_t from = 0;
        for (int c = 0; c < s.nchannels; ++c) {
            const OIIO::TypeDesc type = s.channelformat(c);
            if (!convert(1, type, from, c)) return false;
            from += type.size();
        }
        return true;
    };
    for (int begin = 0; begin < s.height; begin += step) {
        const int end = std::min(begin + step, s.height);
        const bool read =
            s.tile_width > 0
                ? input_->read_tiles(subimage_, 0, s.x, s.x + s.width, s.y + begin, s.y + end, s.z,
                                     s.z + 1, 0, s.nchannels, OIIO::TypeDesc::FLOAT, rows.data())
                : read_lines(begin, end);
        // It returns true for strips that it could not read.
        if (!read || input_->has_error()) return trouble(input_->geterror());
        for (int y = begin; y < end; ++y) {
            Result<void> used = use(y, rows.data() + row_floats * static_cast<size_t>(y - begin));
            if (!used) return used;
        }
    }
    return {};
}

Error StillImage::not_opened() const {
    const Error said = trouble(input_->geterror());
    if (format_ != "openexr") return said;
    const Result<ExrHeader> header = read_exr_header(file_);
    const std::string_view newer = header ? newer_exr_compression(header->compression) : "";
    if (newer.empty()) return said;
    return user_error(fmt::format(messages::kExrCompressionNotRead, newer, header->compression),
                      messages::kExrCompressionNotReadHelp);
}

Error StillImage::trouble(std::string reason) const {
    const std::string name = file_.name();
    for (size_t at = reason.find(name); at != std::string::npos; at = reason.find(name))
        reason.replace(at, name.size(), shown_);
    return user_error(reason.empty() ? messages::kPictureDamaged : reason);
}

}  // namespace openfab::tools
