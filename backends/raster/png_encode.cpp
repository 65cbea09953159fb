// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/png_encode.h"

#include <libdeflate.h>

#include <cmath>
#include <cstring>
#include <memory>

namespace openfab::raster {

namespace {

struct CompressorDelete {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

void put_u32(std::vector<uint8_t>& out, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(static_cast<uint8_t>(value >> shift));
}

/// Starts a chunk and returns where; end_chunk sets its length and checksum.
size_t begin_chunk(std::vector<uint8_t>& out, const char* type) {
    const size_t at = out.size();
    put_u32(out, 0);
    out.insert(out.end(), type, type + 4);
    return at;
}

void end_chunk(std::vector<uint8_t>& out, size_t at) {
    const auto length = static_cast<uint32_t>(out.size() - at - 8);
    for (int i = 0; i < 4; ++i)
        out[at + static_cast<size_t>(i)] = static_cast<uint8_t>(length >> (24 - 8 * i));
    put_u32(out, libdeflate_crc32(0, out.data() + at + 4, length + 4));
}

void put_palette(std::vector<uint8_t>& out, const PngImage& image) {
    size_t chunk = begin_chunk(out, "PLTE");
    for (const std::array<uint8_t, 4>& c : image.palette)
        out.insert(out.end(), c.begin(), c.begin() + 3);
    end_chunk(out, chunk);
    chunk = begin_chunk(out, "tRNS");
    for (const std::array<uint8_t, 4>& c : image.palette)
        out.push_back(c[3]);
    end_chunk(out, chunk);
}

void put_pitch(std::vector<uint8_t>& out, const PngImage& image) {
    if (image.pixels_per_metre_x <= 0 || image.pixels_per_metre_y <= 0) return;
    const size_t chunk = begin_chunk(out, "pHYs");
    put_u32(out, static_cast<uint32_t>(std::floor(image.pixels_per_metre_x + 0.5)));
    put_u32(out, static_cast<uint32_t>(std::floor(image.pixels_per_metre_y + 0.5)));
    out.push_back(1);  // the unit is the metre
    end_chunk(out, chunk);
}

void put_text(std::vector<uint8_t>& out, const std::string& text) {
    if (text.empty()) return;
    const size_t chunk = begin_chunk(out, "tEXt");
    constexpr char kKeyword[] = "Software";
    out.insert(out.end(), kKeyword, kKeyword + sizeof(kKeyword));  // with its end mark
    out.insert(out.end(), text.begin(), text.end());
    end_chunk(out, chunk);
}

}  // namespace

std::vector<uint8_t> encode_png(const PngImage& image, int level) {
    const std::unique_ptr<libdeflate_compressor, CompressorDelete> compressor(
        libdeflate_alloc_compressor(level));
    if (compressor == nullptr) return {};
    constexpr std::array<uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    std::vector<uint8_t> out(kSignature.begin(), kSignature.end());
    size_t chunk = begin_chunk(out, "IHDR");
    put_u32(out, static_cast<uint32_t>(image.width));
    put_u32(out, static_cast<uint32_t>(image.height));
    out.push_back(static_cast<uint8_t>(image.bits));
    out.push_back(static_cast<uint8_t>(image.color));
    out.insert(out.end(), 3, uint8_t{0});  // deflate, adaptive filters, not interlaced
    end_chunk(out, chunk);
    if (image.color == PngColor::kIndexed) put_palette(out, image);
    put_pitch(out, image);
    put_text(out, image.text);

    chunk = begin_chunk(out, "IDAT");
    const size_t at = out.size();
    const size_t bound = libdeflate_zlib_compress_bound(compressor.get(), image.rows.size());
    out.resize(at + bound);
    const size_t packed = libdeflate_zlib_compress(compressor.get(), image.rows.data(),
                                                   image.rows.size(), out.data() + at, bound);
    if (packed == 0) return {};
    out.resize(at + packed);
    end_chunk(out, chunk);
    end_chunk(out, begin_chunk(out, "IEND"));
    out.shrink_to_fit();
    return out;
}

}  // namespace openfab::raster
