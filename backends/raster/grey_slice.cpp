// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/grey_slice.h"

#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "backends/raster/png_encode.h"

namespace openfab::raster {

namespace {

constexpr const char* kSoftware = "OpenFab";

struct CompressorDelete {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

/// Puts row `y` of the picture, 0 at its top; 16 bits in the given order of bytes.
void put_row(std::span<const float> fractions, const pipeline::PrintInfo& info,
             const FolderOptions& options, int32_t y, bool high_first, uint8_t* to) {
    const bool wide = is_grey_of_16_bits(options.format);
    const float whole = wide ? 65535.0f : 255.0f;
    const auto width = static_cast<size_t>(info.size.x);
    const float* row = fractions.data() + static_cast<size_t>(info.size.y - 1 - y) * width;
    for (size_t x = 0; x < width; ++x) {
        const float fraction = row[options.flip_x ? width - 1 - x : x];
        const auto value = static_cast<uint32_t>(std::floor(fraction * whole + 0.5f));
        if (!wide) {
            to[x] = static_cast<uint8_t>(value);
            continue;
        }
        to[2 * x] = static_cast<uint8_t>(high_first ? value >> 8 : value);
        to[2 * x + 1] = static_cast<uint8_t>(high_first ? value : value >> 8);
    }
}

void put(std::vector<uint8_t>& out, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i)
        out.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

/// Baseline TIFF 6.0, little-endian, one strip: header, directory, resolutions, pixels.
std::vector<uint8_t> encode_tiff(std::span<const uint8_t> packed, const pipeline::PrintInfo& info,
                                 int bits) {
    struct Entry {
        uint32_t tag, type, count, value;
    };
    constexpr uint32_t kShort = 3, kLong = 4, kRational = 5;
    constexpr uint32_t kEntries = 13, kHeader = 8, kDirectory = 2 + kEntries * 12 + 4;
    constexpr uint32_t kResolutions = kHeader + kDirectory, kPixels = kResolutions + 16;
    const auto width = static_cast<uint32_t>(info.size.x);
    const auto height = static_cast<uint32_t>(info.size.y);
    const Entry entries[kEntries] = {
        {256, kLong, 1, width},
        {257, kLong, 1, height},
        {258, kShort, 1, static_cast<uint32_t>(bits)},
        {259, kShort, 1, 8},  // Deflate
        {262, kShort, 1, 1},  // 0 is black
        {273, kLong, 1, kPixels},
        {274, kShort, 1, 1},  // the first row is the top
        {277, kShort, 1, 1},  // channels
        {278, kLong, 1, height},
        {279, kLong, 1, static_cast<uint32_t>(packed.size())},
        {282, kRational, 1, kResolutions},
        {283, kRational, 1, kResolutions + 8},
        {296, kShort, 1, 3},  // pixels a centimetre
    };
    std::vector<uint8_t> out{'I', 'I', 42, 0};
    put(out, kHeader, 4);
    put(out, kEntries, 2);
    for (const Entry& entry : entries) {
        put(out, entry.tag, 2);
        put(out, entry.type, 2);
        put(out, entry.count, 4);
        put(out, entry.value, 4);
    }
    put(out, 0, 4);
    for (const double pitch_mm : {info.pitch_mm.x, info.pitch_mm.y}) {
        put(out, static_cast<uint32_t>(std::lround(1e5 / pitch_mm)), 4);
        put(out, 10'000, 4);
    }
    out.insert(out.end(), packed.begin(), packed.end());
    return out;
}

std::vector<uint8_t> deflated(std::span<const uint8_t> rows) {
    constexpr int kLevel = 2;
    const std::unique_ptr<libdeflate_compressor, CompressorDelete> compressor(
        libdeflate_alloc_compressor(kLevel));
    if (compressor == nullptr) return {};
    std::vector<uint8_t> packed(libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
    packed.resize(libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                           packed.data(), packed.size()));
    return packed;
}

}  // namespace

bool is_tiff(SliceFormat format) {
    return format == SliceFormat::kTiff8 || format == SliceFormat::kTiff16;
}

bool is_grey_of_16_bits(SliceFormat format) {
    return format == SliceFormat::kGrey16 || format == SliceFormat::kTiff16;
}

bool is_grey(SliceFormat format) {
    return is_tiff(format) || format == SliceFormat::kGrey8 || format == SliceFormat::kGrey16;
}

std::vector<uint8_t> encode_grey(std::span<const float> fractions, const pipeline::PrintInfo& info,
                                 const FolderOptions& options) {
    const int bits = is_grey_of_16_bits(options.format) ? 16 : 8;
    if (!is_tiff(options.format)) {
        PngImage image;
        image.width = info.size.x;
        image.height = info.size.y;
        image.color = PngColor::kGrey;
        image.bits = bits;
        image.pixels_per_metre_x = 1000 / info.pitch_mm.x;
        image.pixels_per_metre_y = 1000 / info.pitch_mm.y;
        image.text = kSoftware;
        return encode_png_rows(image, [&](int32_t y, uint8_t* row) {
            put_row(fractions, info, options, y, true, row);
        });
    }
    const size_t stride = static_cast<size_t>(info.size.x) * static_cast<size_t>(bits / 8);
    std::vector<uint8_t> rows(stride * static_cast<size_t>(info.size.y));
    for (int32_t y = 0; y < info.size.y; ++y)
        put_row(fractions, info, options, y, false, rows.data() + stride * static_cast<size_t>(y));
    const std::vector<uint8_t> packed = deflated(rows);
    return packed.empty() ? packed : encode_tiff(packed, info, bits);
}

std::vector<uint8_t> encode_grey_slice(const pipeline::SliceView& slice,
                                       const pipeline::PrintInfo& info,
                                       const FolderOptions& options) {
    const int32_t wanted = grey_material(info, options) + 1;
    const auto width = static_cast<size_t>(slice.width);
    std::vector<float> fractions(width * static_cast<size_t>(slice.height));
    for (int32_t y = 0; y < slice.height; ++y) {
        for (int32_t x = 0; x < slice.width; ++x) {
            const bool there = slice.code(x, y, info.bits) == wanted;
            fractions[static_cast<size_t>(y) * width + static_cast<size_t>(x)] = there ? 1 : 0;
        }
    }
    return encode_grey(fractions, info, options);
}

int32_t grey_material(const pipeline::PrintInfo& info, const FolderOptions& options) {
    if (options.grey_material.empty()) return 0;
    for (const auto member : {&pipeline::SliceMaterial::name, &pipeline::SliceMaterial::channel}) {
        const auto found = std::find_if(
            info.materials.begin(), info.materials.end(),
            [&](const pipeline::SliceMaterial& m) { return m.*member == options.grey_material; });
        if (found != info.materials.end())
            return static_cast<int32_t>(found - info.materials.begin());
    }
    return -1;
}

}  // namespace openfab::raster
