// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/shard.h"

#include <zstd.h>

#include <bit>
#include <cstring>
#include <memory>
#include <utility>

#include "base/crc32c.h"
#include "base/hash.h"

namespace openfab::zarr {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

namespace {

constexpr uint64_t kLeftOut = ~uint64_t{0};
constexpr size_t kEntryBytes = 2 * sizeof(uint64_t);

/// Or nullptr: no memory.
ZSTD_CCtx* make_context() {
    ZSTD_CCtx* context = ZSTD_createCCtx();
    if (context == nullptr) return nullptr;
    // Matches that are short cost more than they save, as in .ofr files (backends/ofr/slice_codec.cpp): of dithered
    // chunks 3 % of the bytes and 5 % of the time.
    for (const auto& [parameter, value] : {std::pair{ZSTD_c_compressionLevel, 1},
                                           {ZSTD_c_minMatch, 7},
                                           {ZSTD_c_hashLog, 12},
                                           {ZSTD_c_checksumFlag, 1}})
        ZSTD_CCtx_setParameter(context, parameter, value);
    return context;
}

}  // namespace

std::vector<uint8_t> compress_chunk(std::span<const uint8_t> codes) {
    struct Context {
        std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{make_context(), &ZSTD_freeCCtx};
        std::vector<uint8_t> room;
    };
    thread_local Context context;
    if (context.zstd == nullptr) return {};
    context.room.resize(std::max(context.room.size(), ZSTD_compressBound(codes.size())));
    const size_t packed = ZSTD_compress2(context.zstd.get(), context.room.data(),
                                         context.room.size(), codes.data(), codes.size());
    if (ZSTD_isError(packed) != 0U) return {};
    return {context.room.begin(), context.room.begin() + static_cast<std::ptrdiff_t>(packed)};
}

bool decompress_chunk(std::span<const uint8_t> frame, std::span<uint8_t> codes) {
    if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != codes.size()) return false;
    const size_t got = ZSTD_decompress(codes.data(), codes.size(), frame.data(), frame.size());
    return ZSTD_isError(got) == 0U && got == codes.size();
}

std::vector<uint8_t> join_frames(std::span<const std::span<const uint8_t>> frames) {
    size_t bytes = 0;
    for (const std::span<const uint8_t> frame : frames)
        bytes += frame.size();
    std::vector<uint8_t> shard;
    if (bytes == 0) return shard;
    shard.reserve(bytes + frames.size() * kEntryBytes + sizeof(uint32_t));
    std::vector<uint64_t> index;
    index.reserve(2 * frames.size());
    for (const std::span<const uint8_t> frame : frames) {
        index.push_back(frame.empty() ? kLeftOut : shard.size());
        index.push_back(frame.empty() ? kLeftOut : frame.size());
        shard.insert(shard.end(), frame.begin(), frame.end());
    }
    const std::span<const uint8_t> raw(reinterpret_cast<const uint8_t*>(index.data()),
                                       index.size() * sizeof(uint64_t));
    shard.insert(shard.end(), raw.begin(), raw.end());
    const uint32_t sum = crc32c(raw);
    const auto* const tail = reinterpret_cast<const uint8_t*>(&sum);
    shard.insert(shard.end(), tail, tail + sizeof sum);
    return shard;
}

std::vector<std::span<const uint8_t>> split_frames(std::span<const uint8_t> shard, size_t chunks) {
    const size_t index_bytes = chunks * kEntryBytes;
    if (shard.size() < index_bytes + sizeof(uint32_t)) return {};
    const size_t frames_end = shard.size() - index_bytes - sizeof(uint32_t);
    const std::span<const uint8_t> raw = shard.subspan(frames_end, index_bytes);
    uint32_t sum = 0;
    std::memcpy(&sum, shard.data() + frames_end + index_bytes, sizeof sum);
    if (sum != crc32c(raw)) return {};
    std::vector<std::span<const uint8_t>> frames(chunks);
    for (size_t i = 0; i < chunks; ++i) {
        uint64_t entry[2];
        std::memcpy(entry, raw.data() + i * kEntryBytes, sizeof entry);
        if (entry[0] == kLeftOut && entry[1] == kLeftOut) continue;
        if (entry[1] == 0 || entry[0] > frames_end || entry[1] > frames_end - entry[0]) return {};
        frames[i] = shard.subspan(entry[0], entry[1]);
    }
    return frames;
}

ShardDigest digest_of(std::span<const uint8_t> shard) {
    return shard.empty() ? ShardDigest() : ShardDigest{shard.size(), xxh3(shard, 0)};
}

}  // namespace openfab::zarr
