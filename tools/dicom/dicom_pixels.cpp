// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_pixels.h"

#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <gdcmReader.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

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

/// Fails where the items that packed pixels lie in do not all end within the file.
Result<void> check_items(const InputFile& file, int64_t at) {
    constexpr int64_t kHead = 8;
    constexpr uint32_t kItem = 0xe000fffe;
    const int64_t begin = at;
    while (at + kHead <= file.bytes()) {
        std::array<uint8_t, kHead> head{};
        const Result<size_t> got = file.read(at, head.data(), head.size());
        if (!got) return got.error();
        const auto number = [&](size_t from) {
            return uint32_t{head[from]} | uint32_t{head[from + 1]} << 8 |
                   uint32_t{head[from + 2]} << 16 | uint32_t{head[from + 3]} << 24;
        };
        if (number(0) != kItem) return {};  // the end, or damage that the library sees
        at += kHead + number(4);
    }
    if (at > file.bytes()) return cut_short(file.bytes() - begin, at - begin);
    return {};
}

/// A stored number, of bytes that lie `step` apart.
float value_of(const DicomSlice& slice, const char* lowest, std::ptrdiff_t step) {
    const DicomImage& image = *slice.image;
    uint64_t bits = 0;
    for (int64_t i = 0; i < image.pixel_bytes(); ++i)
        bits |= uint64_t{static_cast<uint8_t>(lowest[i * step])} << (8 * i);
    const uint64_t mask = (uint64_t{1} << image.bits_stored) - 1;
    bits = bits >> (image.high_bit + 1 - image.bits_stored) & mask;
    auto stored = static_cast<int64_t>(bits);
    if (image.has_sign && (bits >> (image.bits_stored - 1)) != 0)
        stored -= static_cast<int64_t>(mask) + 1;
    return static_cast<float>(static_cast<double>(stored) * slice.slope + slice.intercept);
}

}  // namespace

Result<void> check_pixels(const DicomImage& image) {
    if (image.is_deflated) return {};
    const Result<InputFile> file = InputFile::open(image.file);
    if (!file) return file.error();
    if (image.is_packed) return check_items(*file, image.pixels_at);
    const int64_t there = std::min(image.pixels_bytes, file->bytes() - image.pixels_at);
    const int64_t needed = image.frames * image.frame_bytes();
    return there < needed ? cut_short(there, needed) : Result<void>();
}

Result<void> DicomPixels::read_plain(const DicomSlice& slice) {
    const DicomImage& image = *slice.image;
    const Result<InputFile> file = InputFile::open(image.file);
    if (!file) return file.error();
    unpacked_ = nullptr;
    // Of pixels of 8 bits in words the second comes first; a word may lie in two frames.
    const bool exchanged = image.is_big_endian && image.has_words && image.pixel_bytes() == 1;
    const int64_t begin = slice.frame * image.frame_bytes(), end = begin + image.frame_bytes();
    const int64_t from = exchanged ? begin / 2 * 2 : begin;
    const int64_t to = exchanged ? (end + 1) / 2 * 2 : end;
    bytes_.resize(static_cast<size_t>(to - from));
    const Result<size_t> got = file->read(image.pixels_at + from, bytes_.data(), bytes_.size());
    if (!got) return got.error();
    if (*got < bytes_.size())
        return cut_short(from + static_cast<int64_t>(*got), image.frames * image.frame_bytes());
    if (!exchanged) return {};
    for (size_t i = 0; i < bytes_.size(); i += 2)
        std::swap(bytes_[i], bytes_[i + 1]);
    bytes_.erase(bytes_.begin(), bytes_.begin() + (begin - from));
    return {};
}

Result<void> DicomPixels::unpack(const std::shared_ptr<const DicomImage>& image) {
    if (unpacked_ == image) return {};
    unpacked_ = nullptr;
    const Result<InputFile> file = InputFile::open(image->file);
    if (!file) return file.error();
    const int64_t all = image->frames * image->frame_bytes();
    // The library has them twice.
    if (Result<void> fits = check_memory(file->bytes() + 3 * all, memory_bytes_); !fits)
        return fits;
    if (image->is_deflated) {
        gdcm::Reader reader;
        reader.SetFileName(file->name().c_str());
        if (!reader.Read()) return user_error(messages::kPixelsDamaged);
        const std::string_view there =
            bytes_of(reader.GetFile().GetDataSet(), gdcm::Tag(0x7fe0, 0x0010));
        if (static_cast<int64_t>(there.size()) < all)
            return cut_short(static_cast<int64_t>(there.size()), all);
        bytes_.assign(there.begin(), there.end());
    } else {
        bytes_.resize(static_cast<size_t>(all));
        gdcm::ImageReader reader;
        reader.SetFileName(file->name().c_str());
        if (!reader.Read() || reader.GetImage().GetBufferLength() != bytes_.size() ||
            !reader.GetImage().GetBuffer(bytes_.data()))
            return user_error(messages::kPackedPixelsDamaged);
    }
    unpacked_ = image;
    return {};
}

Result<void> DicomPixels::read(const DicomSlice& slice, float* out) {
    const DicomImage& image = *slice.image;
    const bool plain = !image.is_packed && !image.is_deflated;
    if (Result<void> got = plain ? read_plain(slice) : unpack(slice.image); !got) return got;
    const int64_t size = image.pixel_bytes(), count = int64_t{image.width} * image.height;
    const char* from = bytes_.data() + (plain ? 0 : slice.frame * image.frame_bytes());
    const bool backwards = image.is_big_endian && size > 1;
    for (int64_t i = 0; i < count; ++i, from += size)
        out[i] = value_of(slice, from + (backwards ? size - 1 : 0), backwards ? -1 : 1);
    return {};
}

}  // namespace openfab::tools
