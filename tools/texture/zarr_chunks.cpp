// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/zarr_chunks.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>
#ifdef OPENFAB_HAS_BLOSC
#include <blosc.h>
#endif

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/crc32c.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

using texture::ZarrCodec;

constexpr size_t kChecksumBytes = 4;

uint32_t checksum(const char* bytes, size_t count) {
    return crc32c({reinterpret_cast<const uint8_t*>(bytes), count});
}

/// What a chunk may have in a file: packed bytes are seldom more than the others.
size_t most_packed(size_t bytes) {
    constexpr size_t kSmall = 1 << 16;
    return 2 * bytes + kSmall;
}

uint64_t number_of(const char* at, size_t bytes, bool big_endian) {
    uint64_t out = 0;
    for (size_t b = 0; b < bytes; ++b) {
        const size_t shift = 8 * (big_endian ? bytes - 1 - b : b);
        out |= static_cast<uint64_t>(static_cast<uint8_t>(at[b])) << shift;
    }
    return out;
}

Error damaged(ZarrCodec codec) {
    return user_error(fmt::format(messages::kZarrChunkDamaged, texture::codec_name(codec)));
}

/// Each fills `out`, which has as many bytes as there may be, and returns how many there are.
Result<size_t> inflate_all(ZarrCodec codec, std::span<const char> from, std::vector<char>* out) {
    constexpr int kGzip = 16;
    z_stream state{};
    const int window = codec == ZarrCodec::kGzip ? kGzip + MAX_WBITS : MAX_WBITS;
    if (inflateInit2(&state, window) != Z_OK) return damaged(codec);
    state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(from.data()));
    size_t left = from.size(), room = out->size();
    state.next_out = reinterpret_cast<Bytef*>(out->data());
    int done = Z_OK;
    while (done == Z_OK) {
        constexpr size_t kMost = std::numeric_limits<uInt>::max();
        state.avail_in = static_cast<uInt>(std::min(left, kMost));
        state.avail_out = static_cast<uInt>(std::min(room, kMost));
        const size_t in = state.avail_in, space = state.avail_out;
        done = inflate(&state, Z_NO_FLUSH);
        left -= in - state.avail_in;
        room -= space - state.avail_out;
        // Neither takes nor gives: cut short, or there is no room.
        if (done == Z_OK && in == state.avail_in && space == state.avail_out) done = Z_BUF_ERROR;
    }
    inflateEnd(&state);
    if (done != Z_STREAM_END || left != 0) return damaged(codec);
    return out->size() - room;
}

Result<size_t> decompress_zstd(std::span<const char> from, std::vector<char>* out) {
    const size_t got = ZSTD_decompress(out->data(), out->size(), from.data(), from.size());
    if (ZSTD_isError(got) != 0) return damaged(ZarrCodec::kZstd);
    return got;
}

Result<size_t> decompress_blosc(std::span<const char> from, std::vector<char>* out) {
#ifdef OPENFAB_HAS_BLOSC
    size_t bytes = 0;
    constexpr size_t kHeader = BLOSC_MIN_HEADER_LENGTH;
    if (from.size() < kHeader || blosc_cbuffer_validate(from.data(), from.size(), &bytes) != 0 ||
        bytes > out->size())
        return damaged(ZarrCodec::kBlosc);
    if (bytes == 0) return bytes;
    const int got = blosc_decompress_ctx(from.data(), out->data(), out->size(), 1);
    if (got >= 0 && static_cast<size_t>(got) == bytes) return bytes;
    const char* const library = blosc_cbuffer_complib(from.data());
    return user_error(
        fmt::format(messages::kZarrChunkDamaged,
                    fmt::format(messages::kZarrBloscOf, library != nullptr ? library : "?")));
#else
    (void)from;
    (void)out;
    return user_error(messages::kZarrNoBlosc, messages::kZarrNoBloscHelp);
#endif
}

}  // namespace

Result<void> decode_chunk(std::span<const ZarrCodec> codecs, size_t bytes,
                          std::vector<char>* chunk) {
    for (size_t c = codecs.size(); c-- > 0;) {
        const ZarrCodec codec = codecs[c];
        if (codec == ZarrCodec::kCrc32c) {
            if (chunk->size() < kChecksumBytes) return user_error(messages::kZarrChecksum);
            const size_t inner = chunk->size() - kChecksumBytes;
            if (number_of(chunk->data() + inner, kChecksumBytes, false) !=
                checksum(chunk->data(), inner))
                return user_error(messages::kZarrChecksum);
            chunk->resize(inner);
            continue;
        }
        std::vector<char> out(c == 0 ? bytes : most_packed(bytes));
        const Result<size_t> got = codec == ZarrCodec::kZstd    ? decompress_zstd(*chunk, &out)
                                   : codec == ZarrCodec::kBlosc ? decompress_blosc(*chunk, &out)
                                                                : inflate_all(codec, *chunk, &out);
        if (!got) return got.error();
        out.resize(*got);
        chunk->swap(out);
    }
    if (chunk->size() == bytes) return {};
    return user_error(fmt::format(messages::kZarrChunkSize, chunk->size(), bytes));
}

Result<ZarrFile> ZarrFile::open(InputFile file, const texture::ZarrArray& array) {
    ZarrFile out(std::move(file), array);
    if (!array.sharded) {
        out.places_ = {{0, static_cast<uint64_t>(out.file_.bytes())}};
        return out;
    }
    if (Result<void> read = out.read_index(); !read) return read.error();
    return out;
}

Result<void> ZarrFile::read_index() {
    constexpr size_t kEntry = 16;
    const auto chunks = static_cast<uint64_t>(array_->chunks_in_file());
    const auto whole = static_cast<uint64_t>(file_.bytes());
    const size_t behind = array_->index_checked ? kChecksumBytes : 0;
    // Compared before they are multiplied.
    if (whole < behind || (whole - behind) / kEntry < chunks)
        return user_error(fmt::format(messages::kZarrShardShort, whole,
                                      static_cast<double>(chunks) * kEntry + behind));
    std::vector<char> index(chunks * kEntry + behind);
    const uint64_t at = array_->index_first ? 0 : whole - index.size();
    const Result<size_t> got = file_.read(static_cast<int64_t>(at), index.data(), index.size());
    if (!got) return got.error();
    if (*got != index.size())
        return user_error(fmt::format(messages::kZarrShardShort, *got, index.size()));
    const size_t entries = index.size() - behind;
    if (behind != 0 &&
        number_of(index.data() + entries, kChecksumBytes, false) != checksum(index.data(), entries))
        return user_error(messages::kZarrIndexChecksum);
    const uint64_t first = array_->index_first ? index.size() : 0;
    const uint64_t end = array_->index_first ? whole : at;
    places_.resize(chunks);
    for (uint64_t c = 0; c < chunks; ++c) {
        Place place;
        place.begin = number_of(index.data() + c * kEntry, 8, array_->index_big_endian);
        place.bytes = number_of(index.data() + c * kEntry + 8, 8, array_->index_big_endian);
        constexpr uint64_t kNone = std::numeric_limits<uint64_t>::max();
        if (place.begin == kNone && place.bytes == kNone) {
            places_[c] = {0, 0};
            continue;
        }
        if (place.begin < first || place.begin > end || place.bytes > end - place.begin ||
            place.bytes == 0)
            return user_error(
                fmt::format(messages::kZarrIndexLies, c, place.bytes, place.begin, whole));
        places_[c] = place;
    }
    return {};
}

Result<bool> ZarrFile::read(int64_t number, std::vector<char>* out) const {
    const Place& place = places_[static_cast<size_t>(number)];
    const auto bytes = static_cast<size_t>(array_->chunk_bytes());
    const auto fail = [&](const Error& error) {
        return array_->sharded ? with_context(error, fmt::format(messages::kZarrOfChunk, number))
                               : error;
    };
    if (place.bytes == 0 && array_->sharded) return false;
    if (place.bytes > most_packed(bytes))
        return fail(user_error(fmt::format(messages::kZarrFileTooLarge, place.bytes, bytes)));
    out->resize(place.bytes);
    const Result<size_t> got =
        file_.read(static_cast<int64_t>(place.begin), out->data(), out->size());
    if (!got) return fail(got.error());
    out->resize(*got);
    if (Result<void> decoded = decode_chunk(array_->codecs, bytes, out); !decoded)
        return fail(decoded.error());
    return true;
}

}  // namespace openfab::tools
