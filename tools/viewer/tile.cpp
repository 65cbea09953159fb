// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/tile.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "backends/raster/png_encode.h"
#include "base/color.h"

namespace openfab::viewer {

namespace {

/// The fastest that still finds runs: pictures go over the loopback.
constexpr int kPngLevel = 1;
constexpr uint32_t kOne = 1023;  ///< 1.0 in a field of a packed sum

/// Four sums in one word: red, green, blue (times alpha) and alpha, 16 bits each, from the lowest.
/// A field holds 64 voxels.
using PackedSum = uint64_t;
constexpr size_t kVoxelsASum = 64;

struct Sum {
    uint64_t red = 0, green = 0, blue = 0, alpha = 0;
    void add(PackedSum sum) {
        red += sum & 0xffff;
        green += (sum >> 16) & 0xffff;
        blue += (sum >> 32) & 0xffff;
        alpha += sum >> 48;
    }
};

/// 0 … kOne of linear light.
uint32_t linear_of(uint8_t byte) {
    static const std::array<uint32_t, 256> table = [] {
        std::array<uint32_t, 256> made{};
        for (size_t i = 0; i < made.size(); ++i) {
            made[i] = static_cast<uint32_t>(
                std::lround(srgb_to_linear(static_cast<double>(i) / 255) * kOne));
        }
        return made;
    }();
    return table[byte];
}

PackedSum packed_color(const std::array<uint8_t, 4>& rgba) {
    const uint32_t alpha = (rgba[3] * kOne + 127) / 255;
    PackedSum sum = PackedSum{alpha} << 48;
    for (int c = 0; c < 3; ++c)
        sum |= PackedSum{(linear_of(rgba[static_cast<size_t>(c)]) * alpha + kOne / 2) / kOne}
               << (16 * c);
    return sum;
}

/// What a byte of packed rows adds: one voxel at 8 bits, two at 4.
std::array<PackedSum, 256> sums_by_byte(const Palette& palette, int32_t bits) {
    std::array<PackedSum, 256> sums{};
    for (size_t byte = 0; byte < sums.size(); ++byte) {
        sums[byte] = bits == 8
                         ? packed_color(palette[byte])
                         : packed_color(palette[byte & 15]) + packed_color(palette[byte >> 4]);
    }
    return sums;
}

/// Adds `bytes` of a row, `bytes_a_pixel` (a power of two) each, to the sums of the pixels.
class RowAdder {
  public:
    RowAdder(const Palette& palette, int32_t bits)
        : table_(sums_by_byte(palette, bits)), voxels_a_byte_(bits == 8 ? 1 : 2) {}

    void add(const uint8_t* row, size_t bytes, size_t bytes_a_pixel, Sum* sums) {
        for (size_t at = 0; at < bytes; at += bytes_a_pixel)
            add_pixel(row + at, std::min(bytes_a_pixel, bytes - at), sums++);
    }

  private:
    void add_pixel(const uint8_t* from, size_t bytes, Sum* sum) {
        const size_t most = kVoxelsASum / voxels_a_byte_;
        while (bytes > 0) {
            const size_t n = std::min(bytes, most);
            sum->add(add_few(from, n));
            from += n;
            bytes -= n;
        }
    }
    PackedSum add_few(const uint8_t* from, size_t bytes) {
        PackedSum sum = 0;
        // Slices are long runs: most words are the word before.
        for (; bytes >= 8; from += 8, bytes -= 8) {
            uint64_t word = 0;
            std::memcpy(&word, from, 8);
            if (word != last_word_) {
                last_word_ = word;
                last_sum_ = 0;
                for (int i = 0; i < 8; ++i)
                    last_sum_ += table_[from[i]];
            }
            sum += last_sum_;
        }
        for (; bytes > 0; ++from, --bytes)
            sum += table_[*from];
        return sum;
    }

    std::array<PackedSum, 256> table_;
    size_t voxels_a_byte_;
    uint64_t last_word_ = 0;
    PackedSum last_sum_ = 8 * table_[0];
};

void put_pixel(const Sum& sum, uint64_t voxels, uint8_t* rgba) {
    if (sum.alpha == 0) return;
    const auto whole = static_cast<double>(sum.alpha);
    rgba[0] = srgb_of(static_cast<double>(sum.red) / whole);
    rgba[1] = srgb_of(static_cast<double>(sum.green) / whole);
    rgba[2] = srgb_of(static_cast<double>(sum.blue) / whole);
    rgba[3] = static_cast<uint8_t>(
        std::lround(std::min(1.0, whole / (static_cast<double>(voxels) * kOne)) * 255));
}

void unpack(const uint8_t* row, int32_t bits, int64_t first, int64_t count, uint8_t* codes) {
    if (bits == 8) {
        std::memcpy(codes, row + first, static_cast<size_t>(count));
        return;
    }
    for (int64_t i = 0; i < count; ++i) {
        const int64_t u = first + i;
        codes[i] = static_cast<uint8_t>((row[u >> 1] >> ((u & 1) * 4)) & 15);
    }
}

std::vector<uint8_t> encode(std::vector<uint8_t> rows, int64_t width, int64_t height,
                            raster::PngColor color, const Palette* palette) {
    raster::PngImage image;
    image.width = static_cast<int32_t>(width);
    image.height = static_cast<int32_t>(height);
    image.color = color;
    image.rows = rows;
    if (palette != nullptr) image.palette.assign(palette->begin(), palette->end());
    return raster::encode_png(image, kPngLevel);
}

}  // namespace

uint8_t srgb_of(double linear) {
    constexpr size_t kSteps = 4096;
    static const std::array<uint8_t, kSteps> table = [] {
        std::array<uint8_t, kSteps> made{};
        for (size_t i = 0; i < kSteps; ++i) {
            made[i] = linear_to_srgb8(static_cast<double>(i) / (kSteps - 1));
        }
        return made;
    }();
    return table[static_cast<size_t>(std::lround(std::clamp(linear, 0.0, 1.0) * (kSteps - 1)))];
}

std::vector<uint8_t> draw_tile(const Plane& plane, const TilePlace& place, const Palette& palette) {
    const int64_t u0 = place.first_u();
    const int64_t v0 = place.first_v();
    const int64_t u1 = std::min(u0 + (int64_t{kTilePixels} << place.level_u), int64_t{plane.width});
    const int64_t v1 = place.end_v(plane.height);
    if (u0 >= u1 || v0 >= v1) return {};
    const int64_t columns = int64_t{1} << place.level_u;
    const int64_t stride = place.rows_a_pixel();
    const int64_t width = (u1 - u0 + columns - 1) / columns;
    const int64_t height = (v1 - v0 + stride - 1) / stride;
    const bool one_voxel = columns == 1 && (stride == 1 || plane.sampled);
    const size_t pixel_bytes = one_voxel ? 1 : 4;
    const size_t row_bytes = 1 + static_cast<size_t>(width) * pixel_bytes;
    std::vector<uint8_t> picture(row_bytes * static_cast<size_t>(height));
    // At 4 bits, columns of one voxel begin within bytes, so these rows are unpacked first.
    const bool unpacked = columns == 1;
    const int32_t bits = unpacked ? 8 : plane.bits;
    const int64_t per_byte = bits == 8 ? 1 : 2;
    RowAdder adder(palette, bits);
    std::vector<uint8_t> codes(unpacked ? static_cast<size_t>(width) : 0);
    std::vector<Sum> sums(one_voxel ? 0 : static_cast<size_t>(width));
    for (int64_t pixel_row = 0; pixel_row < height; ++pixel_row) {
        uint8_t* out = picture.data() + row_bytes * static_cast<size_t>(height - 1 - pixel_row) + 1;
        const int64_t first = v0 + pixel_row * stride;
        const int64_t end = plane.sampled ? first + 1 : std::min(first + stride, v1);
        std::fill(sums.begin(), sums.end(), Sum{});
        for (int64_t v = first; v < end; ++v) {
            const uint8_t* row = plane.row(static_cast<int32_t>(v));
            if (row == nullptr) continue;
            if (unpacked) unpack(row, plane.bits, u0, u1 - u0, codes.data());
            if (one_voxel) {
                std::memcpy(out, codes.data(), codes.size());
                continue;
            }
            const uint8_t* from = unpacked ? codes.data() : row + u0 / per_byte;
            const auto bytes = static_cast<size_t>((u1 - u0 + per_byte - 1) / per_byte);
            adder.add(from, bytes, static_cast<size_t>(columns / per_byte), sums.data());
        }
        for (int64_t u = 0; u < static_cast<int64_t>(sums.size()); ++u) {
            const int64_t across = std::min(columns, u1 - u0 - u * columns);
            put_pixel(sums[static_cast<size_t>(u)], static_cast<uint64_t>(across * (end - first)),
                      out + u * 4);
        }
    }
    return encode(std::move(picture), width, height,
                  one_voxel ? raster::PngColor::kIndexed : raster::PngColor::kRgba,
                  one_voxel ? &palette : nullptr);
}

}  // namespace openfab::viewer
