// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_image.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>

#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"
#include "tools/texture/tiff_numbers.h"
#include "tools/texture/tiff_pages.h"
#include "tools/texture/tiff_sums.h"

namespace openfab::tools {

/// The library's view of a file.
struct TiffImage::Handle {
    Handle(const InputFile& from, uint64_t directory) : file(from), header(from, directory) {}
    ~Handle() {
        if (tiff != nullptr) TIFFClose(tiff);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;

    const InputFile& file;
    TiffHeader header;
    int64_t at = 0;
    int64_t shift = 0;  ///< of what is read of the pixels
    TIFF* tiff = nullptr;
    std::string error;  ///< the first since it was cleared
    std::string warning;
};

namespace {

tmsize_t read_bytes(thandle_t handle, void* to, tmsize_t bytes) {
    auto* const in = static_cast<TiffImage::Handle*>(handle);
    if (in->at < 0 || bytes < 0) return 0;
    const int64_t at = in->at + in->shift;
    const Result<size_t> got = in->file.read(at, to, static_cast<size_t>(bytes));
    if (!got) return 0;
    in->header.put(at, *got, static_cast<char*>(to));
    in->at += static_cast<int64_t>(*got);
    return static_cast<tmsize_t>(*got);
}

tmsize_t write_nothing(thandle_t, void*, tmsize_t) {
    return 0;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
    auto* const in = static_cast<TiffImage::Handle*>(handle);
    const int64_t from = whence == SEEK_CUR ? in->at : whence == SEEK_END ? in->file.bytes() : 0;
    in->at = static_cast<int64_t>(static_cast<uint64_t>(from) + offset);
    return static_cast<toff_t>(in->at);
}

int close_nothing(thandle_t) {
    return 0;
}

toff_t size_of(thandle_t handle) {
    return static_cast<toff_t>(static_cast<TiffImage::Handle*>(handle)->file.bytes());
}

int map_nothing(thandle_t, void**, toff_t*) {
    return 0;
}

void unmap_nothing(thandle_t, void*, toff_t) {}

void keep(std::string* first, const char* format, va_list values) {
    if (!first->empty()) return;
    std::array<char, 512> text{};
    const int length = std::vsnprintf(text.data(), text.size(), format, values);
    first->assign(text.data(),
                  static_cast<size_t>(std::clamp(length, 0, static_cast<int>(text.size()) - 1)));
    if (first->empty()) *first = "?";
}

int on_error(TIFF*, void* handle, const char*, const char* format, va_list values) {
    keep(&static_cast<TiffImage::Handle*>(handle)->error, format, values);
    return 1;
}

int on_warning(TIFF*, void* handle, const char*, const char* format, va_list values) {
    keep(&static_cast<TiffImage::Handle*>(handle)->warning, format, values);
    return 1;
}

TIFF* open_tiff(TiffImage::Handle* handle, int64_t memory_bytes) {
    TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
    if (options == nullptr) return nullptr;
    TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(memory_bytes));
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, handle);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, handle);
    TIFF* const tiff =
        TIFFClientOpenExt("", "rm", handle, read_bytes, write_nothing, seek, close_nothing, size_of,
                          map_nothing, unmap_nothing, options);
    TIFFOpenOptionsFree(options);
    return tiff;
}

template <typename T>
T field(TIFF* tiff, uint32_t tag, T otherwise) {
    T value = otherwise;
    return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}

std::string compression_name(int compression) {
    struct Name {
        int compression;
        const char* name;
    };
    // Those that the library may not know by name.
    constexpr std::array<Name, 9> kNames{{{33003, "JPEG 2000"},
                                          {33005, "JPEG 2000"},
                                          {34712, "JPEG 2000"},
                                          {34933, "PNG"},
                                          {34934, "JPEG XR"},
                                          {22610, "JPEG XR"},
                                          {50002, "JPEG XL"},
                                          {52546, "JPEG XL"},
                                          {50013, "Pixtiff"}}};
    for (const Name& known : kNames) {
        if (known.compression == compression) return known.name;
    }
    const TIFFCodec* const codec = TIFFFindCODEC(static_cast<uint16_t>(compression));
    return codec != nullptr ? codec->name : "";
}

/// Whether the decoder only warns of data that is damaged, and goes on with what it has.
bool only_warns(int compression) {
    return compression == COMPRESSION_JPEG || compression == COMPRESSION_OJPEG ||
           compression == COMPRESSION_CCITTRLE || compression == COMPRESSION_CCITTRLEW ||
           compression == COMPRESSION_CCITTFAX3 || compression == COMPRESSION_CCITTFAX4;
}

}  // namespace

bool TiffDirectory::is_plain() const {
    constexpr int kCfa = 32803, kLinearRaw = 34892;
    return photometric == PHOTOMETRIC_MINISBLACK || photometric == PHOTOMETRIC_MINISWHITE ||
           photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_MASK ||
           photometric == kCfa || photometric == kLinearRaw ||
           (photometric == PHOTOMETRIC_YCBCR && compression == COMPRESSION_JPEG);
}

bool TiffDirectory::is_colour() const {
    return photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR;
}

bool TiffDirectory::is_palette() const {
    return photometric == PHOTOMETRIC_PALETTE;
}

TiffImage::TiffImage(const InputFile& file, uint64_t directory)
    : handle_(std::make_unique<Handle>(file, directory)) {}

TiffImage::~TiffImage() = default;

Result<std::unique_ptr<TiffImage>> TiffImage::open(const InputFile& file, uint64_t directory,
                                                   int64_t memory_bytes) {
    std::unique_ptr<TiffImage> image(new TiffImage(file, directory));
    Handle& handle = *image->handle_;
    handle.tiff = open_tiff(&handle, memory_bytes / 2);
    if (handle.tiff == nullptr) return image->trouble(messages::kPictureDamaged);
    if (Result<void> read = image->read_directory(memory_bytes); !read) return read.error();
    return image;
}

Error TiffImage::trouble(const std::string& what, const char* help) const {
    return user_error(handle_->error.empty() ? what : what + ": " + handle_->error, help);
}

Result<void> TiffImage::read_directory(int64_t memory_bytes) {
    TIFF* const tiff = handle_->tiff;
    const auto width = field<uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
    const auto height = field<uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
    const auto depth = field<uint32_t>(tiff, TIFFTAG_IMAGEDEPTH, 1);
    if (width < 1 || height < 1 || depth < 1) return user_error(messages::kPictureEmpty);
    constexpr uint32_t kMostSide = 1 << 24;
    for (const uint32_t side : {width, height, depth}) {
        if (side > kMostSide) return user_error(fmt::format(messages::kSideNotPossible, side));
    }
    about_.width = static_cast<int32_t>(width);
    about_.height = static_cast<int32_t>(height);
    about_.depth = static_cast<int32_t>(depth);
    about_.samples = field<uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    about_.bits = field<uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
    about_.photometric = field<uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    about_.compression = field<uint16_t>(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    about_.orientation = field<uint16_t>(tiff, TIFFTAG_ORIENTATION, 1);
    about_.separate = about_.samples > 1 && field<uint16_t>(tiff, TIFFTAG_PLANARCONFIG, 1) == 2;
    about_.reduced = (field<uint32_t>(tiff, TIFFTAG_SUBFILETYPE, 0) &
                      (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
    about_.resolution = {static_cast<double>(field<float>(tiff, TIFFTAG_XRESOLUTION, 0)),
                         static_cast<double>(field<float>(tiff, TIFFTAG_YRESOLUTION, 0))};
    about_.resolution_unit = field<uint16_t>(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
    char* text = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr)
        about_.description = text;
    if (TIFFGetField(tiff, TIFFTAG_SOFTWARE, &text) == 1 && text != nullptr) about_.software = text;
    read_private();
    if (Result<void> known = check_kind(); !known) return known;
    if (about_.photometric == PHOTOMETRIC_YCBCR && about_.compression == COMPRESSION_JPEG)
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    const bool tiled = TIFFIsTiled(tiff) != 0;
    about_.rows = tiled ? field<uint32_t>(tiff, TIFFTAG_TILELENGTH, 0)
                        : field<uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP, UINT32_MAX);
    // The library decodes the first layer of a tile alone, and counts the strips of one layer.
    if (depth > 1 && (!tiled || field<uint32_t>(tiff, TIFFTAG_TILEDEPTH, 1) > 1))
        return user_error(messages::kDepthNotRead, messages::kDepthNotReadHelp);
    if (about_.rows < 1) return user_error(messages::kPictureDamaged);
    if (!tiled) about_.rows = std::min<int64_t>(about_.rows, height);
    const uint64_t chunk =
        tiled ? TIFFTileSize64(tiff) : TIFFVStripSize64(tiff, static_cast<uint32_t>(about_.rows));
    const uint64_t band = static_cast<uint64_t>(about_.rows) * width *
                          static_cast<uint64_t>(about_.samples) * sizeof(float);
    constexpr uint64_t kMost = uint64_t{1} << 60;
    if (chunk == 0) return trouble(messages::kPictureDamaged);
    // Stored and decoded, then as floats.
    const uint64_t needed = std::min(chunk, kMost) * 2 + std::min(band, kMost);
    return check_memory(static_cast<int64_t>(2 * std::min(needed, kMost)), memory_bytes);
}

void TiffImage::read_private() {
    TIFF* const tiff = handle_->tiff;
    constexpr uint32_t kStk = 33629;
    uint32_t count = 0;
    const void* value = nullptr;
    // Not known to the library, which guesses their types from the file.
    if (TIFFGetField(tiff, kStk, &count, &value) == 1) about_.stk_planes = count;
    const std::pair<uint32_t, std::string*> texts[] = {{34412, &about_.lsm},
                                                       {34361, &about_.fluoview},
                                                       {51123, &about_.micro_manager},
                                                       {42112, &about_.scaling},
                                                       {42113, &about_.no_data}};
    for (const auto& [tag, text] : texts) {
        const TIFFField* const known = TIFFFindField(tiff, tag, TIFF_ANY);
        // Numbers of one byte each.
        if (known == nullptr || TIFFDataWidth(TIFFFieldDataType(known)) != 1 ||
            TIFFGetField(tiff, tag, &count, &value) != 1 || value == nullptr)
            continue;
        text->assign(static_cast<const char*>(value), count);
    }
}

Result<void> TiffImage::check_kind() {
    const auto compression = static_cast<uint16_t>(about_.compression);
    if (TIFFIsCODECConfigured(compression) == 0) {
        return user_error(
            fmt::format(messages::kCompressionNotRead, compression_name(compression), compression),
            messages::kCompressionNotReadHelp);
    }
    switch (field<uint16_t>(handle_->tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT)) {
        case SAMPLEFORMAT_UINT:
        case SAMPLEFORMAT_VOID:
            about_.kind = TiffDirectory::Kind::kUnsigned;
            break;
        case SAMPLEFORMAT_INT:
            about_.kind = TiffDirectory::Kind::kSigned;
            break;
        case SAMPLEFORMAT_IEEEFP:
            about_.kind = TiffDirectory::Kind::kFloat;
            break;
        default:
            return user_error(fmt::format(messages::kNumbersAre, "complex"),
                              messages::kNumbersAreHelp);
    }
    if (!knows_samples(about_)) {
        return user_error(
            fmt::format(messages::kSamplesNotRead, about_.bits,
                        about_.kind == TiffDirectory::Kind::kFloat    ? "floats"
                        : about_.kind == TiffDirectory::Kind::kSigned ? "signed integers"
                                                                      : "integers"),
            messages::kSamplesNotReadHelp);
    }
    return {};
}

Result<void> TiffImage::check_places() const {
    TIFF* const tiff = handle_->tiff;
    const bool tiled = TIFFIsTiled(tiff) != 0;
    const uint32_t chunks = tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
    const auto size = static_cast<uint64_t>(handle_->file.bytes());
    const uint64_t plain = about_.compression == COMPRESSION_NONE
                               ? (tiled ? TIFFTileSize64(tiff) : TIFFStripSize64(tiff))
                               : UINT64_MAX;
    for (uint32_t chunk = 0; chunk < chunks; ++chunk) {
        const uint64_t begin = TIFFGetStrileOffset(tiff, chunk);
        const uint64_t bytes = std::min(TIFFGetStrileByteCount(tiff, chunk), plain);
        if (begin == 0 || bytes == 0 || begin > size || bytes > size - begin)
            return user_error(fmt::format(messages::kChunkMissing, tiled ? "tile" : "strip", chunk),
                              messages::kChunkHelp);
    }
    return {};
}

Result<void> TiffImage::check_chunks() {
    TIFF* const tiff = handle_->tiff;
    const bool tiled = TIFFIsTiled(tiff) != 0;
    const uint32_t chunks = tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
    const auto height = static_cast<uint32_t>(about_.height);
    const auto step = static_cast<uint32_t>(about_.rows);
    const uint32_t in_plane = (height + step - 1) / step;
    for (uint32_t chunk = 0; chunk < chunks; ++chunk) {
        const uint32_t begin = chunk % in_plane * step;
        const tmsize_t bytes =
            tiled ? TIFFTileSize(tiff) : TIFFVStripSize(tiff, std::min(step, height - begin));
        if (Result<void> read = read_chunk(chunk, bytes); !read) return read;
    }
    return {};
}

int64_t TiffImage::contiguous_begin() const {
    TIFF* const tiff = handle_->tiff;
    if (about_.compression != COMPRESSION_NONE || TIFFIsTiled(tiff) != 0) return -1;
    const uint32_t strips = TIFFNumberOfStrips(tiff);
    uint64_t next = TIFFGetStrileOffset(tiff, 0);
    const uint64_t begin = next;
    for (uint32_t strip = 0; strip < strips; ++strip) {
        if (TIFFGetStrileOffset(tiff, strip) != next) return -1;
        next += TIFFGetStrileByteCount(tiff, strip);
    }
    constexpr uint64_t kMost = uint64_t{1} << 60;
    return begin > 0 && begin < kMost ? static_cast<int64_t>(begin) : -1;
}

Result<void> TiffImage::each_row(int32_t z, Scale scale, int64_t shift, const UseRow& use) {
    const bool tiled = TIFFIsTiled(handle_->tiff) != 0;
    const auto row_floats = static_cast<size_t>(about_.width) * static_cast<size_t>(about_.samples);
    std::vector<float> band(row_floats * static_cast<size_t>(about_.rows));
    handle_->shift = shift;
    for (int64_t y = 0; y < about_.height; y += about_.rows) {
        if (Result<void> read =
                tiled ? read_tiles(z, y, scale, band.data()) : read_strips(y, scale, band.data());
            !read)
            return read;
        const int64_t end = std::min<int64_t>(y + about_.rows, about_.height);
        for (int64_t row = y; row < end; ++row) {
            const float* const at = band.data() + static_cast<size_t>(row - y) * row_floats;
            if (Result<void> used = use(static_cast<int32_t>(row), at); !used) return used;
        }
    }
    return {};
}

Result<void> TiffImage::read_chunk(uint32_t chunk, int64_t bytes) {
    TIFF* const tiff = handle_->tiff;
    const bool tiled = TIFFIsTiled(tiff) != 0;
    bytes_.resize(static_cast<size_t>(bytes));
    handle_->error.clear();
    handle_->warning.clear();
    // A chunk without a place was never written; the library would read the file's header.
    if (TIFFGetStrileOffset(tiff, chunk) == 0)
        return user_error(fmt::format(messages::kChunkDamaged, tiled ? "tile" : "strip", chunk),
                          messages::kChunkHelp);
    const tmsize_t got = tiled ? TIFFReadEncodedTile(tiff, chunk, bytes_.data(), bytes)
                               : TIFFReadEncodedStrip(tiff, chunk, bytes_.data(), bytes);
    if (handle_->error.empty() && only_warns(about_.compression)) handle_->error = handle_->warning;
    if (got == bytes && handle_->error.empty() && has_right_end(chunk)) return {};
    if (about_.compression == COMPRESSION_OJPEG)
        return user_error(messages::kOldJpegNotRead, messages::kOldJpegHelp);
    return trouble(fmt::format(messages::kChunkDamaged, tiled ? "tile" : "strip", chunk),
                   messages::kChunkHelp);
}

bool TiffImage::has_right_end(uint32_t chunk) {
    if (!has_sums(about_.compression)) return true;
    TIFF* const tiff = handle_->tiff;
    TiffChunk read{chunk, &bytes_};
    if (TIFFIsTiled(tiff) == 0) {
        const auto in_plane =
            static_cast<uint32_t>((about_.height + about_.rows - 1) / about_.rows);
        read.whole_bytes = TIFFVStripSize(tiff, static_cast<uint32_t>(about_.rows));
        read.may_be_longer = chunk % in_plane + 1 == in_plane &&
                             read.whole_bytes > static_cast<int64_t>(bytes_.size());
    }
    const bool right = has_right_sum(tiff, about_.compression, read, &handle_->error);
    if (right) handle_->error.clear();
    return right;
}

void TiffImage::convert(const uint8_t* row, int64_t pixels, Scale scale, int sample, float* out) {
    const int64_t count = about_.separate ? pixels : pixels * about_.samples;
    convert_samples(about_, scale, row, count, about_.separate ? about_.samples : 1, out + sample,
                    &rounded_);
}

Result<void> TiffImage::read_strips(int64_t y, Scale scale, float* band) {
    const int64_t rows = std::min<int64_t>(about_.rows, about_.height - y);
    const int planes = about_.separate ? about_.samples : 1;
    const int64_t samples = int64_t{about_.width} * (about_.separate ? 1 : about_.samples);
    const int64_t row_bytes = (samples * about_.bits + 7) / 8;
    for (int plane = 0; plane < planes; ++plane) {
        const uint32_t strip =
            TIFFComputeStrip(handle_->tiff, static_cast<uint32_t>(y), static_cast<uint16_t>(plane));
        if (Result<void> read = read_chunk(strip, rows * row_bytes); !read) return read;
        for (int64_t row = 0; row < rows; ++row) {
            convert(bytes_.data() + row * row_bytes, about_.width, scale, plane,
                    band + row * about_.width * about_.samples);
        }
    }
    return {};
}

Result<void> TiffImage::read_tiles(int32_t z, int64_t y, Scale scale, float* band) {
    TIFF* const tiff = handle_->tiff;
    const int64_t width = field<uint32_t>(tiff, TIFFTAG_TILEWIDTH, 0);
    const int64_t bytes = TIFFTileSize(tiff);
    const int planes = about_.separate ? about_.samples : 1;
    const int64_t row_bytes =
        (width * (about_.separate ? 1 : about_.samples) * about_.bits + 7) / 8;
    if (width < 1 || bytes < row_bytes * about_.rows) return user_error(messages::kPictureDamaged);
    const int64_t rows = std::min<int64_t>(about_.rows, about_.height - y);
    for (int64_t x = 0; x < about_.width; x += width) {
        for (int plane = 0; plane < planes; ++plane) {
            const uint32_t tile =
                TIFFComputeTile(tiff, static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                static_cast<uint32_t>(z), static_cast<uint16_t>(plane));
            if (Result<void> read = read_chunk(tile, bytes); !read) return read;
            for (int64_t row = 0; row < rows; ++row) {
                convert(bytes_.data() + row * row_bytes, std::min(width, about_.width - x), scale,
                        plane, band + (row * about_.width + x) * about_.samples);
            }
        }
    }
    return {};
}

}  // namespace openfab::tools
