// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/png_encode.h"

#include <isa-l/igzip_lib.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace openfab::raster {

namespace {

struct CompressorDelete {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
};

struct Free {
    void operator()(void* memory) const { std::free(memory); }
};

struct DecompressorDelete {
    void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
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
    out.insert(out.end(), kKeyword, kKeyword + sizeof(kKeyword));  // with its terminating 0
    out.insert(out.end(), text.begin(), text.end());
    end_chunk(out, chunk);
}

/// Writes everything before the pixels.
std::vector<uint8_t> begin_file(const PngImage& image) {
    constexpr std::array<uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    std::vector<uint8_t> out(kSignature.begin(), kSignature.end());
    const size_t chunk = begin_chunk(out, "IHDR");
    put_u32(out, static_cast<uint32_t>(image.width));
    put_u32(out, static_cast<uint32_t>(image.height));
    out.push_back(static_cast<uint8_t>(image.bits));
    out.push_back(static_cast<uint8_t>(image.color));
    out.insert(out.end(), 3, uint8_t{0});  // deflate, adaptive filters, not interlaced
    end_chunk(out, chunk);
    if (image.color == PngColor::kIndexed) put_palette(out, image);
    put_pitch(out, image);
    put_text(out, image.text);
    return out;
}

void end_file(std::vector<uint8_t>& out) {
    end_chunk(out, begin_chunk(out, "IEND"));
}

size_t row_bytes(const PngImage& image) {
    const size_t channels = image.color == PngColor::kRgba  ? 4
                            : image.color == PngColor::kRgb ? 3
                                                            : 1;
    const size_t bits = static_cast<size_t>(image.bits) * channels;
    return 1 + (static_cast<size_t>(image.width) * bits + 7) / 8;
}

}  // namespace

std::vector<uint8_t> encode_png(const PngImage& image, int level) {
    const std::unique_ptr<libdeflate_compressor, CompressorDelete> compressor(
        libdeflate_alloc_compressor(level));
    if (compressor == nullptr) return {};
    std::vector<uint8_t> out = begin_file(image);
    const size_t chunk = begin_chunk(out, "IDAT");
    const size_t bound = libdeflate_zlib_compress_bound(compressor.get(), image.rows.size());
    // The worst case is as large as the picture; untouched memory costs nothing.
    const std::unique_ptr<uint8_t, Free> packed(static_cast<uint8_t*>(std::malloc(bound)));
    if (packed == nullptr) return {};
    const size_t bytes = libdeflate_zlib_compress(compressor.get(), image.rows.data(),
                                                  image.rows.size(), packed.get(), bound);
    if (bytes == 0) return {};
    out.insert(out.end(), packed.get(), packed.get() + bytes);
    end_chunk(out, chunk);
    end_file(out);
    out.shrink_to_fit();
    return out;
}

namespace {

/// Kept from slice to slice: what ISA-L works in, and rows on their way into it.
struct SliceDeflater {
    isal_zstream stream;
    std::vector<uint8_t> tables = std::vector<uint8_t>(ISAL_DEF_LVL1_DEFAULT);
    std::vector<uint8_t> rows;
    std::unique_ptr<uint8_t, Free> packed;  ///< its pages are there once they are touched
    size_t packed_bytes = 0;
};

/// Compresses all rows; empty where there was no room. The bytes stay until the thread's next call.
std::span<const uint8_t> deflate_rows(const PngImage& image, const PutRow& put_row) {
    // As many rows at a time as stay in the L2 cache. The bytes depend on their number, so it is
    // one for all machines.
    constexpr size_t kBytesAtOnce = 256 << 10;
    // Large: it holds 64 KiB of history.
    thread_local const auto deflater = std::make_unique<SliceDeflater>();
    const size_t stride = row_bytes(image);
    const auto rows_at_once = static_cast<int32_t>(std::max<size_t>(kBytesAtOnce / stride, 1));
    deflater->rows.resize(std::max(deflater->rows.size(), stride * rows_at_once));
    // Bytes that look like noise grow by a percent or two; no chunk is longer than a file may have.
    const size_t raw = stride * static_cast<size_t>(image.height);
    const size_t bound = std::min<size_t>(raw + raw / 8 + (64 << 10), INT32_MAX);
    if (deflater->packed_bytes < bound) {
        deflater->packed.reset(static_cast<uint8_t*>(std::malloc(bound)));
        deflater->packed_bytes = deflater->packed == nullptr ? 0 : bound;
        if (deflater->packed == nullptr) return {};
    }
    isal_zstream& stream = deflater->stream;
    isal_deflate_init(&stream);
    stream.level = 1;
    stream.level_buf = deflater->tables.data();
    stream.level_buf_size = static_cast<uint32_t>(deflater->tables.size());
    stream.gzip_flag = IGZIP_ZLIB;
    stream.flush = NO_FLUSH;
    stream.next_out = deflater->packed.get();
    stream.avail_out = static_cast<uint32_t>(bound);
    for (int32_t y = 0; y < image.height;) {
        const int32_t end = y + std::min(rows_at_once, image.height - y);
        uint8_t* row = deflater->rows.data();
        for (; y < end; ++y, row += stride) {
            *row = 0;  // no filter
            put_row(y, row + 1);
        }
        stream.next_in = deflater->rows.data();
        stream.avail_in = static_cast<uint32_t>(row - deflater->rows.data());
        stream.end_of_stream = end == image.height ? 1 : 0;
        if (isal_deflate(&stream) != COMP_OK || stream.avail_in != 0) return {};
    }
    if (stream.internal_state.state != ZSTATE_END) return {};
    return {deflater->packed.get(), bound - stream.avail_out};
}

}  // namespace

std::vector<uint8_t> encode_png_rows(const PngImage& image, const PutRow& put_row) {
    const std::span<const uint8_t> packed = deflate_rows(image, put_row);
    if (packed.empty()) return {};
    constexpr size_t kChunk = 12;  // length, type, checksum
    std::vector<uint8_t> out = begin_file(image);
    // The bytes wait in a queue, so they take no more than they need.
    out.reserve(out.size() + kChunk + packed.size() + kChunk);
    const size_t chunk = begin_chunk(out, "IDAT");
    out.insert(out.end(), packed.begin(), packed.end());
    end_chunk(out, chunk);
    end_file(out);
    return out;
}

std::vector<uint8_t> decode_png(std::span<const uint8_t> file, const PngImage& image) {
    const std::vector<uint8_t> head = begin_file(image);
    std::vector<uint8_t> tail;
    end_file(tail);
    constexpr size_t kChunk = 12;  // length, type, checksum
    if (file.size() < head.size() + kChunk + tail.size() ||
        !std::equal(head.begin(), head.end(), file.begin()) ||
        !std::equal(tail.begin(), tail.end(), file.end() - static_cast<long>(tail.size())))
        return {};
    // Reads one chunk of pixels, whose length and checksum must match.
    const std::span<const uint8_t> chunk =
        file.subspan(head.size(), file.size() - head.size() - tail.size());
    const std::span<const uint8_t> packed = chunk.subspan(8, chunk.size() - kChunk);
    std::vector<uint8_t> frame;
    put_u32(frame, static_cast<uint32_t>(packed.size()));
    frame.insert(frame.end(), {'I', 'D', 'A', 'T'});
    put_u32(frame, libdeflate_crc32(0, chunk.data() + 4, packed.size() + 4));
    if (!std::equal(frame.begin(), frame.begin() + 8, chunk.begin()) ||
        !std::equal(frame.begin() + 8, frame.end(), chunk.end() - 4))
        return {};
    const std::unique_ptr<libdeflate_decompressor, DecompressorDelete> decompressor(
        libdeflate_alloc_decompressor());
    if (decompressor == nullptr) return {};
    std::vector<uint8_t> rows(row_bytes(image) * static_cast<size_t>(image.height));
    // Without a pointer for the actual size, other sizes are errors.
    if (libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), rows.data(),
                                   rows.size(), nullptr) != LIBDEFLATE_SUCCESS)
        return {};
    return rows;
}

}  // namespace openfab::raster
