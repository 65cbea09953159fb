// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_pixels.h"

#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "base/at.h"
#include "base/input_file.h"
#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/messages.h"
#include "tools/texture/check_memory.h"

namespace openfab::tools {

namespace {

Error cut_short(int64_t there, int64_t needed) {
    return user_error(fmt::format(messages::kPixelsCutShort, there, needed),
                      messages::kCopyItAgain);
}

gdcm::Tag tag_of(SampleKind sample) {
    const uint16_t element = sample == SampleKind::kFloat    ? 0x0008
                             : sample == SampleKind::kDouble ? 0x0009
                                                             : 0x0010;
    return {0x7fe0, element};
}

std::string little(uint64_t value, size_t bytes) {
    std::string out;
    for (size_t i = 0; i < bytes; ++i)
        out += static_cast<char>(value >> (8 * i) & 0xff);
    return out;
}

std::string element(uint16_t group, uint16_t item, const std::string& kind, std::string value) {
    if (value.size() % 2 != 0) value += kind == "UI" || kind == "OB" ? '\0' : ' ';
    std::string head = little(group, 2) + little(item, 2) + kind;
    head += kind == "OB" ? little(0, 2) + little(value.size(), 4) : little(value.size(), 2);
    return head + value;
}

/// A file of one packed frame, of a kind of object that the library has always known: it takes neither
/// newer ones nor frames in several items.
std::string file_of_frame(const DicomImage& image, const std::string& packed) {
    const std::string object = "1.2.840.10008.5.1.4.1.1.7";
    const auto number = [](uint16_t item, int32_t value) {
        return element(0x28, item, "US", little(static_cast<uint64_t>(value), 2));
    };
    std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", object) +
                       element(2, 3, "UI", "1.2.3") + element(2, 0x10, "UI", image.syntax.codec);
    meta = element(2, 0, "UL", little(meta.size(), 4)) + meta;
    const std::string item = little(0xfffe, 2) + little(0xe000, 2);
    const std::string padding(packed.size() % 2, '\0');
    return std::string(128, '\0') + "DICM" + meta + element(8, 0x16, "UI", object) +
           element(8, 0x18, "UI", "1.2.3") + number(2, 1) +
           element(0x28, 4, "CS", image.is_inverted ? "MONOCHROME1" : "MONOCHROME2") +
           number(0x10, image.height) + number(0x11, image.width) +
           number(0x100, image.bits_allocated) + number(0x101, image.bits_stored) +
           number(0x102, image.high_bit) + number(0x103, image.has_sign ? 1 : 0) +
           little(0x7fe0, 2) + little(0x10, 2) + "OB" + little(0, 2) + little(0xffffffff, 4) +
           item + little(0, 4) + item + little(packed.size() + padding.size(), 4) + packed +
           padding + little(0xfffe, 2) + little(0xe0dd, 2) + little(0, 4);
}

/// How stored bits become numbers.
struct Stored {
    explicit Stored(const DicomImage& image)
        : bytes(image.bits_allocated / 8),
          shift(image.high_bit + 1 - image.bits_stored),
          mask((uint64_t{1} << image.bits_stored) - 1),
          sign(image.has_sign ? uint64_t{1} << (image.bits_stored - 1) : 0) {}

    int64_t bytes;
    int shift;
    uint64_t mask, sign;

    /// Of bytes that lie `step` apart, the lowest first.
    double number(const char* lowest, std::ptrdiff_t step) const {
        uint64_t bits = 0;
        for (int64_t i = 0; i < bytes; ++i)
            bits |= uint64_t{static_cast<uint8_t>(lowest[i * step])} << (8 * i);
        bits = bits >> shift & mask;
        auto stored = static_cast<int64_t>(bits);
        if ((bits & sign) != 0) stored -= static_cast<int64_t>(mask) + 1;
        return static_cast<double>(stored);
    }
};

double real_number(const char* lowest, std::ptrdiff_t step, int64_t bytes) {
    std::array<char, sizeof(double)> in_order{};
    for (int64_t i = 0; i < bytes; ++i)
        at(in_order, i) = lowest[i * step];
    return *binary_number({in_order.data(), static_cast<size_t>(bytes)});
}

bool fits_float(double value) {
    return std::isnan(value) || static_cast<double>(static_cast<float>(value)) == value;
}

}  // namespace

Result<void> check_pixels(DicomImage* image) {
    if (image->syntax.packing == Packing::kDeflatedFile) return {};
    const Result<InputFile> file = InputFile::open(image->file);
    if (!file) return file.error();
    if (image->sample == SampleKind::kBit && image->syntax.packing == Packing::kCodec)
        return user_error(fmt::format(messages::kPackedBits, image->syntax.identifier),
                          messages::kWriteUncompressed);
    if (!image->is_plain()) {
        Result<PackedFrames> frames =
            find_packed_frames(*file, image->pixels_at, image->frames, image->long_offsets);
        if (!frames) return frames.error();
        image->packed = std::move(*frames);
        return {};
    }
    const int64_t there = std::min(image->pixels_bytes, file->bytes() - image->pixels_at);
    const int64_t needed = image->all_bytes();
    image->behind_bytes = std::max<int64_t>(0, there - needed);
    return there < needed ? cut_short(there, needed) : Result<void>();
}

Result<DicomPixels::Frame> DicomPixels::read_plain(const DicomSlice& slice) {
    const DicomImage& image = *slice.image;
    const Result<InputFile> file = InputFile::open(image.file);
    if (!file) return file.error();
    inflated_ = nullptr;
    // Of pixels of 8 bits in words the second comes first; a word may lie in two frames.
    const bool exchanged =
        image.syntax.is_big_endian && image.has_words && image.bits_allocated <= 8;
    const int64_t first_bit = slice.frame * image.frame_bits();
    const int64_t begin = first_bit / 8, end = (first_bit + image.frame_bits() + 7) / 8;
    const int64_t from = exchanged ? begin / 2 * 2 : begin;
    const int64_t to = exchanged ? (end + 1) / 2 * 2 : end;
    bytes_.resize(static_cast<size_t>(to - from));
    const Result<size_t> got = file->read(image.pixels_at + from, bytes_.data(), bytes_.size());
    if (!got) return got.error();
    if (*got < bytes_.size())
        return cut_short(from + static_cast<int64_t>(*got), image.all_bytes());
    for (size_t i = 0; exchanged && i < bytes_.size(); i += 2)
        std::swap(bytes_[i], bytes_[i + 1]);
    return Frame{std::string_view(bytes_).substr(static_cast<size_t>(begin - from)), first_bit % 8};
}

Result<DicomPixels::Frame> DicomPixels::read_deflated(const DicomSlice& slice) {
    const DicomImage& image = *slice.image;
    if (inflated_ != slice.image) {
        inflated_ = nullptr;
        const Result<InputFile> file = InputFile::open(image.file);
        if (!file) return file.error();
        const int64_t all = image.all_bytes();
        // The library has them twice.
        if (Result<void> fits = check_memory(file->bytes() + 3 * all, memory_bytes_); !fits)
            return fits.error();
        gdcm::Reader reader;
        reader.SetFileName(file->name().c_str());
        if (!reader.Read()) return user_error(messages::kPixelsDamaged);
        const std::string_view there =
            bytes_of(reader.GetFile().GetDataSet(), tag_of(image.sample));
        if (static_cast<int64_t>(there.size()) < all)
            return cut_short(static_cast<int64_t>(there.size()), all);
        bytes_ = there;
        inflated_ = slice.image;
    }
    const int64_t first_bit = slice.frame * image.frame_bits();
    return Frame{std::string_view(bytes_).substr(static_cast<size_t>(first_bit / 8)),
                 first_bit % 8};
}

Result<void> DicomPixels::decode(const DicomImage& image, const std::string& packed) {
    std::istringstream file(file_of_frame(image, packed));
    gdcm::ImageReader reader;
    reader.SetStream(file);
    bytes_.resize(static_cast<size_t>(image.frame_bytes()));
    if (!reader.Read() || reader.GetImage().GetBufferLength() != bytes_.size() ||
        !reader.GetImage().GetBuffer(bytes_.data()))
        return user_error(image.syntax.name.empty()
                              ? std::string(messages::kPackedPixelsDamaged)
                              : fmt::format(messages::kCompressionNotDecoded, image.syntax.name,
                                            image.syntax.identifier),
                          image.syntax.name.empty() ? "" : messages::kWriteUncompressed);
    return {};
}

Result<DicomPixels::Frame> DicomPixels::read_packed(const DicomSlice& slice) {
    const DicomImage& image = *slice.image;
    const Result<InputFile> file = InputFile::open(image.file);
    if (!file) return file.error();
    inflated_ = nullptr;
    const std::vector<PackedItem>& items = image.packed[static_cast<size_t>(slice.frame)];
    int64_t packed_bytes = 0;
    for (const PackedItem& item : items)
        packed_bytes += item.bytes;
    // The library has each twice.
    if (Result<void> fits = check_memory(3 * packed_bytes + 3 * image.frame_bytes(), memory_bytes_);
        !fits)
        return fits.error();
    Result<std::string> packed = read_packed_frame(*file, items);
    if (!packed) return packed.error();
    if (image.syntax.packing == Packing::kCodec) {
        if (Result<void> decoded = decode(image, *packed); !decoded) return decoded.error();
    } else if (image.syntax.packing == Packing::kDeflatedFrames) {
        Result<std::string> frame = inflate_frame(*packed, image.frame_bytes());
        if (!frame) return frame.error();
        bytes_ = std::move(*frame);
    } else {
        bytes_ = std::move(*packed);
    }
    if (static_cast<int64_t>(bytes_.size()) < image.frame_bytes())
        return cut_short(static_cast<int64_t>(bytes_.size()), image.frame_bytes());
    return Frame{bytes_, 0};
}

void DicomPixels::convert(const DicomSlice& slice, const Frame& frame, float* out) {
    const DicomImage& image = *slice.image;
    const auto finish = [&](double stored) {
        if (slice.range && !(stored >= slice.range->first && stored <= slice.range->second))
            return std::numeric_limits<float>::quiet_NaN();
        if (slice.only) return stored == *slice.only ? 1.0F : 0.0F;
        return static_cast<float>(stored * slice.slope + slice.intercept);
    };
    const int64_t count = image.pixels();
    const char* from = frame.bytes.data();
    if (image.sample == SampleKind::kBit) {
        for (int64_t i = 0; i < count; ++i) {
            const int64_t bit = frame.first_bit + i;
            const auto byte = static_cast<uint8_t>(from[bit / 8]);
            out[i] = finish(byte >> (bit % 8) & 1);
        }
        return;
    }
    const int64_t size = image.bits_allocated / 8;
    const bool backwards = image.syntax.is_big_endian && image.is_plain() && size > 1;
    const std::ptrdiff_t step = backwards ? -1 : 1;
    if (backwards) from += size - 1;
    if (image.sample == SampleKind::kInteger) {
        const Stored stored(image);
        // Others have no more digits than a float keeps.
        constexpr int kFloatBits = 24;
        const bool is_long = image.bits_stored > kFloatBits;
        for (int64_t i = 0; i < count; ++i, from += size) {
            const double number = stored.number(from, step);
            has_rounded_ = has_rounded_ || (is_long && !fits_float(number));
            out[i] = finish(number);
        }
        return;
    }
    for (int64_t i = 0; i < count; ++i, from += size) {
        const double number = real_number(from, step, size);
        has_rounded_ = has_rounded_ || (size > 4 && !fits_float(number));
        out[i] = finish(number);
    }
}

Result<void> DicomPixels::read(const DicomSlice& slice, float* out) {
    const Packing packing = slice.image->syntax.packing;
    const Result<Frame> frame = packing == Packing::kPlain          ? read_plain(slice)
                                : packing == Packing::kDeflatedFile ? read_deflated(slice)
                                                                    : read_packed(slice);
    if (!frame) return frame.error();
    convert(slice, *frame, out);
    return {};
}

}  // namespace openfab::tools
