// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/exif.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

namespace openfab::tools {
namespace {

constexpr int kMostSegments = 65536;

/// Returns `count` bytes of a file; nothing where it ends before.
template <size_t count>
std::optional<std::array<uint8_t, count>> bytes_at(const InputFile& file, int64_t at) {
    std::array<uint8_t, count> out{};
    if (at < 0) return std::nullopt;
    const Result<size_t> got = file.read(at, out.data(), count);
    if (!got || *got < count) return std::nullopt;
    return out;
}

uint32_t big(const uint8_t* bytes, int count) {
    uint32_t out = 0;
    for (int k = 0; k < count; ++k)
        out = out << 8 | bytes[k];
    return out;
}

/// Calls use(marker, begin, length) for the segments of a JPEG before its pixels, until it returns true.
template <typename Use>
void each_segment(const InputFile& file, const Use& use) {
    int64_t at = 2;
    for (int k = 0; k < kMostSegments; ++k) {
        const auto head = bytes_at<4>(file, at);
        if (!head || (*head)[0] != 0xff) return;
        if ((*head)[1] == 0xff) {  // padding
            ++at;
            continue;
        }
        constexpr uint8_t kScan = 0xda, kEnd = 0xd9;
        const int64_t length = big(head->data() + 2, 2);
        if ((*head)[1] == kScan || (*head)[1] == kEnd || length < 2) return;
        if (use((*head)[1], at + 4, length - 2)) return;
        at += 2 + length;
    }
}

/// Returns where the TIFF structure with the EXIF data begins; -1 where there is none.
int64_t exif_begin(const InputFile& file, std::string_view format) {
    if (format == "tiff") return 0;
    int64_t found = -1;
    if (format == "jpeg") {
        each_segment(file, [&](uint8_t marker, int64_t begin, int64_t length) {
            constexpr uint8_t kApp1 = 0xe1;
            const auto name = bytes_at<6>(file, begin);
            if (marker != kApp1 || length < 6 || !name ||
                std::memcmp(name->data(), "Exif\0\0", 6) != 0)
                return false;
            found = begin + 6;
            return true;
        });
    } else if (format == "png") {
        int64_t at = 8;
        for (int k = 0; k < kMostSegments && found < 0; ++k) {
            const auto head = bytes_at<8>(file, at);
            if (!head || std::memcmp(head->data() + 4, "IEND", 4) == 0) break;
            if (std::memcmp(head->data() + 4, "eXIf", 4) == 0) found = at + 8;
            at += 12 + int64_t{big(head->data(), 4)};
        }
    }
    return found;
}

/// A TIFF structure's directories.
class Directories {
  public:
    Directories(const InputFile& file, int64_t begin) : file_(file), begin_(begin) {
        const auto head = bytes_at<8>(file, begin);
        if (!head) return;
        little_ = (*head)[0] == 'I';
        if ((*head)[0] != (*head)[1] || (!little_ && (*head)[0] != 'M') ||
            number(head->data() + 2, 2) != 42)
            return;
        first_ = number(head->data() + 4, 4);
    }
    uint32_t first() const { return first_; }

    /// Returns the four bytes of a tag's value, or nothing.
    std::optional<std::array<uint8_t, 4>> find(uint32_t directory, uint32_t tag) const {
        if (directory == 0) return std::nullopt;
        const auto count = bytes_at<2>(file_, begin_ + directory);
        if (!count) return std::nullopt;
        for (uint32_t k = 0; k < number(count->data(), 2); ++k) {
            const auto entry = bytes_at<12>(file_, begin_ + directory + 2 + 12 * int64_t{k});
            if (!entry) return std::nullopt;
            if (number(entry->data(), 2) != tag) continue;
            return std::array<uint8_t, 4>{(*entry)[8], (*entry)[9], (*entry)[10], (*entry)[11]};
        }
        return std::nullopt;
    }
    /// Same, as a number of two or four bytes; 0 where there is none.
    uint32_t find_number(uint32_t directory, uint32_t tag, int bytes) const {
        const auto value = find(directory, tag);
        return value ? number(value->data(), bytes) : 0;
    }

  private:
    uint32_t number(const uint8_t* bytes, int count) const {
        if (!little_) return big(bytes, count);
        uint32_t out = 0;
        for (int k = count; k-- > 0;)
            out = out << 8 | bytes[k];
        return out;
    }

    const InputFile& file_;
    int64_t begin_ = 0;
    bool little_ = false;
    uint32_t first_ = 0;
};

}  // namespace

ExifColors exif_colors(const InputFile& file, std::string_view format) {
    const int64_t begin = exif_begin(file, format);
    if (begin < 0) return ExifColors::kUnsaid;
    const Directories tiff(file, begin);
    constexpr uint32_t kExif = 0x8769, kInterop = 0xa005, kColorSpace = 0xa001, kIndex = 1;
    constexpr uint32_t kUncalibrated = 65535, kAdobe = 2;  // the latter is of old cameras
    const uint32_t exif = tiff.find_number(tiff.first(), kExif, 4);
    const uint32_t space = tiff.find_number(exif, kColorSpace, 2);
    if (space == kAdobe) return ExifColors::kAdobeRgb;
    if (space != kUncalibrated) return ExifColors::kUnsaid;
    const auto index = tiff.find(tiff.find_number(exif, kInterop, 4), kIndex);
    const bool r03 = index && std::memcmp(index->data(), "R03", 3) == 0;
    return r03 ? ExifColors::kAdobeRgb : ExifColors::kUncalibrated;
}

int jpeg_components(const InputFile& file) {
    int components = 0;
    each_segment(file, [&](uint8_t marker, int64_t begin, int64_t length) {
        // Frames, but tables of Huffman (c4), an extension (c8) and arithmetic coding (cc).
        const bool frame =
            marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (!frame || length < 6) return false;
        if (const auto head = bytes_at<6>(file, begin)) components = (*head)[5];
        return true;
    });
    return components;
}

}  // namespace openfab::tools
