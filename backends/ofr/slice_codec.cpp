// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/slice_codec.h"

#include <zstd.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "backends/ofr/messages.h"

namespace openfab::ofr {

namespace {

/// Or nullptr: no memory.
ZSTD_CCtx* make_context() {
    ZSTD_CCtx* context = ZSTD_createCCtx();
    if (context == nullptr) return nullptr;
    // Repeats in slices are long and close by, so short matches cost more bytes than they save,
    // and a small table, which stays in the L1 cache, finds as much (docs/measurements/prints.md).
    for (const auto& [parameter, value] : {std::pair{ZSTD_c_compressionLevel, kZstdLevel},
                                           {ZSTD_c_minMatch, 7},
                                           {ZSTD_c_hashLog, 12}})
        ZSTD_CCtx_setParameter(context, parameter, value);
    return context;
}

}  // namespace

std::vector<uint8_t> encode_slice(const pipeline::SliceView& slice) {
    // Kept from slice to slice: the tables that zstd works in, and room for the worst case.
    struct Context {
        std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{make_context(), &ZSTD_freeCCtx};
        std::vector<uint8_t> room;
    };
    thread_local Context context;
    const size_t raw = slice.row_bytes * static_cast<size_t>(slice.height);
    context.room.resize(std::max(context.room.size(), ZSTD_compressBound(raw)));
    if (context.zstd == nullptr) return {};  // no memory; commit reports it
    const size_t packed = ZSTD_compress2(context.zstd.get(), context.room.data(),
                                         context.room.size(), slice.data, raw);
    if (ZSTD_isError(packed) != 0U) return {};
    const std::array<uint8_t, kSliceHeadBytes> head =
        write_slice_head({slice.z, static_cast<uint32_t>(packed), checksum({slice.data, raw})});
    // The bytes wait in a queue, so they take no more than they need.
    std::vector<uint8_t> bytes;
    bytes.reserve(kSliceHeadBytes + packed);
    bytes.assign(head.begin(), head.end());
    bytes.insert(bytes.end(), context.room.begin(),
                 context.room.begin() + static_cast<std::ptrdiff_t>(packed));
    return bytes;
}

Result<void> decode_frame(const SliceHead& head, std::span<const uint8_t> frame,
                          std::span<uint8_t> rows) {
    if (ZSTD_getFrameContentSize(frame.data(), frame.size()) != rows.size())
        return user_error(messages::kDataDamaged);
    const size_t got = ZSTD_decompress(rows.data(), rows.size(), frame.data(), frame.size());
    if (ZSTD_isError(got) != 0U || got != rows.size()) return user_error(messages::kDataDamaged);
    if (checksum(rows) != head.rows_checksum) return user_error(messages::kChecksumWrong);
    return {};
}

std::array<int64_t, 256> count_codes(std::span<const uint8_t> rows, int32_t bits) {
    std::array<int64_t, 256> bytes{};
    for (const uint8_t byte : rows)
        ++bytes[byte];
    if (bits == 8) return bytes;
    std::array<int64_t, 256> codes{};
    for (size_t byte = 0; byte < bytes.size(); ++byte) {
        codes[byte & 15] += bytes[byte];
        codes[byte >> 4] += bytes[byte];
    }
    return codes;
}

size_t most_frame_bytes(size_t raw) {
    return ZSTD_compressBound(raw);
}

}  // namespace openfab::ofr
