// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/picture_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "tools/texture/exr_header.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

struct Signature {
    std::string_view bytes;
    const char* reader;
};

using namespace std::string_view_literals;

constexpr std::array kSignatures = {Signature{"\x89PNG\r\n\x1a\n"sv, "png"},
                                    Signature{"\xff\xd8\xff"sv, "jpeg"},
                                    Signature{"II*\0"sv, "tiff"},
                                    Signature{"MM\0*"sv, "tiff"},
                                    Signature{"II+\0"sv, "tiff"},
                                    Signature{"MM\0+"sv, "tiff"},
                                    Signature{"\x76\x2f\x31\x01"sv, "openexr"},
                                    Signature{"#?RADIANCE"sv, "hdr"},
                                    Signature{"#?RGBE"sv, "hdr"},
                                    Signature{"GIF87a"sv, "gif"},
                                    Signature{"GIF89a"sv, "gif"}};

/// The first bytes of a file; numbers in them have their lowest byte first.
class Head {
  public:
    explicit Head(std::string_view bytes) : bytes_(bytes) {}
    std::string_view text() const { return bytes_; }
    bool has(size_t bytes) const { return bytes_.size() >= bytes; }
    int64_t number(size_t at, size_t bytes) const {
        int64_t value = 0;
        for (size_t k = bytes; k-- > 0;)
            value = value << 8 | static_cast<uint8_t>(at + k < bytes_.size() ? bytes_[at + k] : 0);
        return value;
    }
    bool is(size_t at, std::string_view bytes) const {
        return bytes_.size() >= at + bytes.size() && bytes_.substr(at, bytes.size()) == bytes;
    }

  private:
    std::string_view bytes_;
};

bool is_pnm(std::string_view head) {
    return head.size() > 2 && head[0] == 'P' &&
           "123456Ff"sv.find(head[1]) != std::string_view::npos &&
           " \t\r\n#"sv.find(head[2]) != std::string_view::npos;
}

/// Truevision's files begin with no signature: a header that makes sense is one.
bool is_targa(const Head& head) {
    constexpr size_t kHeader = 18;
    if (!head.has(kHeader)) return false;
    const int64_t mapped = head.number(1, 1), type = head.number(2, 1), bits = head.number(16, 1);
    const int64_t map_bits = head.number(7, 1), beyond = head.number(17, 1) & 0xc0;
    const bool map_type = type == 1 || type == 9;
    const bool type_known = map_type || type == 2 || type == 3 || type == 10 || type == 11;
    const bool map_fits = mapped == 1
                              ? map_bits == 15 || map_bits == 16 || map_bits == 24 || map_bits == 32
                              : mapped == 0 && !map_type && head.number(3, 5) == 0;
    const bool bits_known = bits == 8 || bits == 15 || bits == 16 || bits == 24 || bits == 32;
    return type_known && map_fits && bits_known && beyond == 0 && head.number(12, 2) > 0 &&
           head.number(14, 2) > 0;
}

/// Returns the memory that libjpeg takes for the coefficients of a progressive picture when the
/// file is opened; 0 if no size is found, which the reader then reports.
int64_t jpeg_bytes(const InputFile& file) {
    constexpr int kMostSegments = 65536;
    int64_t at = 2;
    for (int k = 0; k < kMostSegments; ++k) {
        std::array<uint8_t, 10> s{};
        const Result<size_t> got = file.read(at, s.data(), s.size());
        if (!got || *got < s.size() || s[0] != 0xff) return 0;
        if (s[1] == 0xff) {  // a fill byte
            ++at;
            continue;
        }
        const bool frame =
            s[1] >= 0xc0 && s[1] <= 0xcf && s[1] != 0xc4 && s[1] != 0xc8 && s[1] != 0xcc;
        if (frame) {
            const int64_t height = s[5] * 256 + s[6], width = s[7] * 256 + s[8], channels = s[9];
            // Blocks at the borders count fully.
            return (width + 32) * (height + 32) * channels * 2;
        }
        const bool alone = s[1] == 0x01 || (s[1] >= 0xd0 && s[1] <= 0xd8);
        at += alone ? 2 : 2 + s[2] * 256 + s[3];
    }
    return 0;
}

/// Of four bytes a pixel; sides are 32 bits at most.
int64_t pixel_bytes(int64_t width, int64_t height) {
    constexpr double kMost = 1e18;
    return static_cast<int64_t>(
        std::min(4 * static_cast<double>(width) * static_cast<double>(height), kMost));
}

void describe_bmp(const Head& head, PictureFormat* format) {
    constexpr int64_t kOldest = 12, kWithAlpha = 108;
    const int64_t size = head.number(14, 4);
    const size_t side = size == kOldest ? 2 : 4;
    const auto length = [&](size_t at) {
        const int64_t value = head.number(at, side);
        // Upside down, where negative.
        return side == 4 ? std::abs(static_cast<int64_t>(static_cast<int32_t>(value))) : value;
    };
    format->at_once = pixel_bytes(length(18), length(18 + side));
    format->bare_alpha = size < kWithAlpha || head.number(66, 4) == 0;
}

void describe_webp(const Head& head, const InputFile& file, PictureFormat* format) {
    constexpr int64_t kSide = 0x3fff;
    int64_t width = head.number(26, 2) & kSide, height = head.number(28, 2) & kSide;
    if (head.is(12, "VP8L")) {
        const int64_t sides = head.number(21, 4);
        width = (sides & kSide) + 1;
        height = (sides >> 14 & kSide) + 1;
    } else if (head.is(12, "VP8X")) {
        width = head.number(24, 3) + 1;
        height = head.number(27, 3) + 1;
    }
    format->at_once = file.bytes() + pixel_bytes(width, height);
}

bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/// Digits, blanks and comments.
class PlainText {
  public:
    PlainText(const char* at, const char* end) : at_(at), end_(end) {}

    /// Returns the next character that counts; 0 at the end.
    char next() {
        while (at_ < end_) {
            const char c = *at_++;
            if (c == '#') {
                at_ = std::find(at_, end_, '\n');
            } else if (!is_blank(c)) {
                return c;
            }
        }
        return 0;
    }
    /// Returns a number and takes what ends it; 0 where there is none below ten million.
    int64_t number() {
        constexpr int64_t kMost = 10'000'000;
        int64_t value = 0;
        char c = next();
        while (c >= '0' && c <= '9' && value < kMost) {
            value = 10 * value + (c - '0');
            c = at_ < end_ ? *at_++ : '\0';
        }
        return is_blank(c) && value < kMost ? value : 0;
    }

  private:
    const char* at_;
    const char* end_;
};

}  // namespace

Result<PictureFormat> picture_format(const InputFile& file) {
    std::array<char, 80> first{};
    const Result<size_t> got = file.read(0, first.data(), first.size());
    if (!got) return got.error();
    const Head head(std::string_view(first.data(), *got));
    PictureFormat format;
    for (const Signature& known : kSignatures) {
        if (head.text().starts_with(known.bytes)) format.reader = known.reader;
    }
    if (format.reader == "jpeg") {
        format.at_once = jpeg_bytes(file);
    } else if (format.reader == "openexr") {
        const Result<ExrHeader> header = read_exr_header(file);
        if (!header) return header.error();
        format.at_once = header->table_bytes;
    } else if (format.reader == "gif") {
        format.fragile = true;
        format.at_once = 2 * pixel_bytes(head.number(6, 2), head.number(8, 2));
    } else if (is_pnm(head.text())) {
        format.reader = "pnm";
        format.at_once = file.bytes();
        format.plain_bits = head.text()[1] == '1';
    } else if (head.is(0, "BM") && head.has(30)) {
        format.reader = "bmp";
        format.fragile = true;
        describe_bmp(head, &format);
    } else if (head.is(0, "RIFF") && head.is(8, "WEBP")) {
        format.reader = "webp";
        format.fragile = true;
        describe_webp(head, file, &format);
    } else if (format.reader.empty() && is_targa(head)) {
        format.reader = "targa";
        format.fragile = true;
        format.at_once = pixel_bytes(head.number(12, 2), head.number(14, 2));
        format.bare_alpha = (head.number(17, 1) & 0x0f) == 0;
    }
    return format;
}

Result<std::vector<char>> packed_bits(const InputFile& plain) {
    std::vector<char> text(static_cast<size_t>(plain.bytes()));
    const Result<size_t> got = plain.read(0, text.data(), text.size());
    if (!got) return got.error();
    text.resize(*got);
    PlainText rest(text.data() + 2, text.data() + text.size());
    const int64_t width = rest.number(), height = rest.number();
    if (width < 1 || height < 1) return user_error(messages::kSizeMissingOrTooLarge);
    if (width * height > static_cast<int64_t>(text.size()))
        return user_error(fmt::format(messages::kBitmapCutShort, width, height));
    const std::string head = fmt::format("P4\n{} {}\n", width, height);
    std::vector<char> out(head.begin(), head.end());
    const auto row_bytes = static_cast<size_t>((width + 7) / 8);
    out.resize(head.size() + row_bytes * static_cast<size_t>(height));
    for (int64_t y = 0; y < height; ++y) {
        char* const row = out.data() + head.size() + row_bytes * static_cast<size_t>(y);
        for (int64_t x = 0; x < width; ++x) {
            const char digit = rest.next();
            if (digit != '0' && digit != '1') {
                return user_error(digit == 0 ? fmt::format(messages::kCutShortAtPixel, x, y)
                                             : fmt::format(messages::kPixelNotABit, x, y));
            }
            if (digit == '1') row[x / 8] = static_cast<char>(row[x / 8] | 0x80 >> x % 8);
        }
    }
    return out;
}

}  // namespace openfab::tools
