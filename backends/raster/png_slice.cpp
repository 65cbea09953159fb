// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/png_slice.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>

#include "backends/common/tee_sink.h"
#include "backends/raster/png_encode.h"

namespace openfab::raster {

namespace {

/// The pixels of every byte of packed rows at 4 bits, the left one first.
using PixelPairs = std::array<std::array<uint32_t, 2>, 256>;

/// Writes the rows of slices as pixels, the largest y first.
class PixelRows {
  public:
    PixelRows(const pipeline::SliceView& slice, const pipeline::PrintInfo& info, bool indexed,
              bool flip_x)
        : slice_(slice),
          indexed_(indexed),
          flip_x_(flip_x),
          bits_(info.bits),
          codes_(static_cast<size_t>(slice.width) + 1) {
        for (size_t i = 0; i < info.materials.size(); ++i)
            std::memcpy(&colors_[i + 1], info.materials[i].key.data(), 4);
        for (size_t byte = 0; byte < pairs_.size(); ++byte)
            pairs_[byte] = {colors_[byte & 15], colors_[byte >> 4]};
    }

    void put(int32_t row, uint8_t* out) {
        const int32_t y = slice_.height - 1 - row;
        const uint8_t* packed = slice_.data + static_cast<size_t>(y) * slice_.row_bytes;
        if (bits_ == 4 && !flip_x_) {
            indexed_ ? swap_halves(packed, out) : put_pairs(packed, out);
            return;
        }
        backends::unpack_row(slice_, y, bits_, codes_.data());
        if (flip_x_) std::reverse(codes_.begin(), codes_.end() - 1);
        indexed_ ? put_indices(out) : put_colors(out);
    }

  private:
    // Most of a slice repeats, 16 pixels at a time.
    void put_pairs(const uint8_t* packed, uint8_t* out) const {
        constexpr size_t kBytes = 8, kPixelBytes = 2 * sizeof(uint32_t) * kBytes;
        const auto width = static_cast<size_t>(slice_.width);
        size_t i = 0;
        while (i + kBytes <= width / 2) {
            for (size_t k = 0; k < kBytes; ++k)
                std::memcpy(out + 8 * k, pairs_[packed[i + k]].data(), 8);
            uint64_t these = 0, next = 0;
            std::memcpy(&these, packed + i, kBytes);
            size_t repeats = 0;
            for (i += kBytes; i + kBytes <= width / 2; i += kBytes, ++repeats) {
                std::memcpy(&next, packed + i, kBytes);
                if (next != these) break;
            }
            repeat(out, kPixelBytes, repeats);
            out += kPixelBytes * (1 + repeats);
        }
        for (; i < width / 2; ++i, out += 8)
            std::memcpy(out, pairs_[packed[i]].data(), 8);
        if (width % 2 != 0) std::memcpy(out, pairs_[packed[i]].data(), 4);
    }
    /// Repeats the first `bytes` so many times more.
    static void repeat(uint8_t* out, size_t bytes, size_t times) {
        const size_t all = bytes * (1 + times);
        for (size_t have = bytes; have < all;) {
            const size_t more = std::min(have, all - have);
            std::memcpy(out + have, out, more);
            have += more;
        }
    }
    /// The first pixel of a byte is in its low half in packed rows and in its high one in PNGs.
    void swap_halves(const uint8_t* packed, uint8_t* out) const {
        constexpr uint64_t kLow = 0x0f0f0f0f0f0f0f0f;
        size_t i = 0;
        for (; i + 8 <= slice_.row_bytes; i += 8) {
            uint64_t eight = 0;
            std::memcpy(&eight, packed + i, 8);
            eight = (eight & kLow) << 4 | (eight >> 4 & kLow);
            std::memcpy(out + i, &eight, 8);
        }
        for (; i < slice_.row_bytes; ++i)
            out[i] = static_cast<uint8_t>(packed[i] << 4 | packed[i] >> 4);
    }
    void put_colors(uint8_t* out) const {
        for (size_t x = 0; x + 1 < codes_.size(); ++x)
            std::memcpy(out + 4 * x, &colors_[codes_[x]], 4);
    }
    void put_indices(uint8_t* out) const {
        if (bits_ == 8) {
            std::copy(codes_.begin(), codes_.end() - 1, out);
            return;
        }
        for (size_t i = 0; i < slice_.row_bytes; ++i)
            out[i] = static_cast<uint8_t>(codes_[2 * i] << 4 | codes_[2 * i + 1]);
    }

    const pipeline::SliceView& slice_;
    bool indexed_, flip_x_;
    int32_t bits_;
    std::array<uint32_t, 256> colors_{};  ///< as bytes lie in memory; void is 0
    PixelPairs pairs_{};
    std::vector<uint8_t> codes_;  ///< of a row, and a void one for the unused half of an odd row
};

/// Makes the image of a slice without its rows.
PngImage image_of(const pipeline::PrintInfo& info, bool indexed) {
    PngImage image;
    image.width = info.size.x;
    image.height = info.size.y;
    image.color = indexed ? PngColor::kIndexed : PngColor::kRgba;
    image.bits = indexed ? info.bits : 8;
    if (indexed) {
        image.palette.push_back({0, 0, 0, 0});
        for (const pipeline::SliceMaterial& material : info.materials)
            image.palette.push_back(material.key);
    }
    image.pixels_per_metre_x = 1000 / info.pitch_mm.x;
    image.pixels_per_metre_y = 1000 / info.pitch_mm.y;
    return image;
}

/// Codes by colour, in memory byte order; fewer entries than codes if two share a colour.
std::map<uint32_t, uint8_t> codes_by_color(const pipeline::PrintInfo& info) {
    std::map<uint32_t, uint8_t> codes{{0, 0}};
    for (size_t i = 0; i < info.materials.size(); ++i) {
        uint32_t color = 0;
        std::memcpy(&color, info.materials[i].key.data(), 4);
        codes.emplace(color, static_cast<uint8_t>(i + 1));
    }
    return codes;
}

/// Decodes a row of pixels without its filter byte; returns false for a colour of no material.
bool read_rgba(const uint8_t* row, const std::map<uint32_t, uint8_t>& codes,
               std::span<uint8_t> out) {
    auto last = codes.begin();
    for (size_t x = 0; x < out.size(); ++x) {
        uint32_t color = 0;
        std::memcpy(&color, row + 4 * x, 4);
        if (color != last->first) last = codes.find(color);
        if (last == codes.end()) return false;
        out[x] = last->second;
    }
    return true;
}

bool read_indices(const uint8_t* row, const pipeline::PrintInfo& info, std::span<uint8_t> out) {
    for (size_t x = 0; x < out.size(); ++x) {
        out[x] =
            info.bits == 8 ? row[x] : static_cast<uint8_t>(row[x / 2] >> (x % 2 == 0 ? 4 : 0) & 15);
        if (out[x] > info.materials.size()) return false;
    }
    return true;
}

}  // namespace

std::vector<uint8_t> encode_png_slice(const pipeline::SliceView& slice,
                                      const pipeline::PrintInfo& info, bool indexed, bool flip_x) {
    PixelRows pixels(slice, info, indexed, flip_x);
    return encode_png_rows(image_of(info, indexed),
                           [&](int32_t row, uint8_t* out) { pixels.put(row, out); });
}

std::vector<uint8_t> decode_png_slice(std::span<const uint8_t> file,
                                      const pipeline::PrintInfo& info, bool indexed) {
    const std::vector<uint8_t> pixels = decode_png(file, image_of(info, indexed));
    if (pixels.empty()) return {};
    const std::map<uint32_t, uint8_t> by_color = codes_by_color(info);
    const auto width = static_cast<size_t>(info.size.x);
    const auto height = static_cast<size_t>(info.size.y);
    const size_t stride = pixels.size() / height;
    std::vector<uint8_t> codes(width * height);
    for (size_t y = 0; y < height; ++y) {
        const uint8_t* from = pixels.data() + stride * (height - 1 - y);
        if (*from != 0) return {};
        const std::span<uint8_t> row(codes.data() + width * y, width);
        if (!(indexed ? read_indices(from + 1, info, row) : read_rgba(from + 1, by_color, row)))
            return {};
    }
    return codes;
}

bool shares_a_color(const pipeline::PrintInfo& info) {
    return codes_by_color(info).size() != info.materials.size() + 1;
}

}  // namespace openfab::raster
