// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_sums.h"

#include <zlib.h>

#include <algorithm>
#include <array>

namespace openfab::tools {

namespace {

std::vector<uint8_t> raw_bytes(TIFF* tiff, uint32_t chunk) {
    // That the file has as many is known by now.
    std::vector<uint8_t> raw(static_cast<size_t>(TIFFGetStrileByteCount(tiff, chunk)));
    const auto bytes = static_cast<tmsize_t>(raw.size());
    const tmsize_t got = TIFFIsTiled(tiff) != 0 ? TIFFReadRawTile(tiff, chunk, raw.data(), bytes)
                                                : TIFFReadRawStrip(tiff, chunk, raw.data(), bytes);
    raw.resize(static_cast<size_t>(std::max<tmsize_t>(0, got)));
    return raw;
}

/// Whether the four bytes behind a stream are the sum of what was decoded, as it came out of the stream.
bool is_sum(TIFF* tiff, const std::vector<uint8_t>& raw, const std::vector<uint8_t>& decoded) {
    uint16_t predictor = PREDICTOR_NONE, bits = 8;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PREDICTOR, &predictor);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    if (predictor != PREDICTOR_NONE || (TIFFIsByteSwapped(tiff) != 0 && bits > 8)) return false;
    uint32_t stored = 0;
    for (size_t i = raw.size() - 4; i < raw.size(); ++i)
        stored = stored << 8 | raw[i];
    return stored == ::adler32_z(::adler32(0, nullptr, 0), decoded.data(), decoded.size());
}

/// Inflates a stream to its end; returns how many bytes it has, negative where it is damaged.
int64_t inflated_bytes(std::vector<uint8_t>* raw) {
    z_stream stream{};
    if (::inflateInit(&stream) != Z_OK) return -1;
    std::array<uint8_t, 1 << 16> out{};
    stream.next_in = raw->data();
    stream.avail_in = static_cast<uInt>(raw->size());
    int status = Z_OK;
    while (status == Z_OK) {
        stream.next_out = out.data();
        stream.avail_out = static_cast<uInt>(out.size());
        status = ::inflate(&stream, Z_NO_FLUSH);
    }
    const auto bytes = static_cast<int64_t>(stream.total_out);
    ::inflateEnd(&stream);
    return status == Z_STREAM_END ? bytes : -1;
}

/// Decodes one byte more than there should be: the library says what is wrong up to the end.
bool ends_well(TIFF* tiff, const TiffChunk& chunk, std::vector<uint8_t>* raw, std::string* error) {
    std::vector<uint8_t> out(chunk.decoded->size() + 1);
    error->clear();
    const bool has_more =
        TIFFReadFromUserBuffer(tiff, chunk.number, raw->data(), static_cast<tmsize_t>(raw->size()),
                               out.data(), static_cast<tmsize_t>(out.size())) != 0 ||
        error->find("rowsize") != std::string::npos;  // which is not a whole row
    const bool damaged = error->find("Decoding error") != std::string::npos;
    return !damaged && (!has_more || chunk.may_be_longer);
}

}  // namespace

bool has_sums(int compression) {
    return compression == COMPRESSION_ADOBE_DEFLATE || compression == COMPRESSION_DEFLATE ||
           compression == COMPRESSION_LZMA;
}

bool has_right_sum(TIFF* tiff, int compression, const TiffChunk& chunk, std::string* error) {
    std::vector<uint8_t> raw = raw_bytes(tiff, chunk.number);
    constexpr size_t kMostAtOnce = UINT32_MAX;
    if (raw.size() < 4 || raw.size() > kMostAtOnce) return raw.size() >= 4;
    if (compression == COMPRESSION_LZMA) return ends_well(tiff, chunk, &raw, error);
    if (is_sum(tiff, raw, *chunk.decoded)) return true;
    const int64_t bytes = inflated_bytes(&raw);
    return bytes == static_cast<int64_t>(chunk.decoded->size()) ||
           (chunk.may_be_longer && bytes == chunk.whole_bytes);
}

}  // namespace openfab::tools
