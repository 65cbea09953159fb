// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A shard as bytes: the zstd frames of its chunks, row by row, and behind them the index: for each chunk u64 offset
// and u64 bytes, both 2^64 - 1 for one that is left out, and u32 CRC-32C of the index.

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"

namespace openfab::zarr {

/// Compresses the codes of a chunk; empty where memory ran out. Threads keep what zstd works in.
std::vector<uint8_t> compress_chunk(std::span<const uint8_t> codes);
/// Decompresses a frame, which must have as many codes as `codes`.
bool decompress_chunk(std::span<const uint8_t> frame, std::span<uint8_t> codes);

/// Joins frames, of which an empty one is left out; returns no bytes where all are.
std::vector<uint8_t> join_frames(std::span<const std::span<const uint8_t>> frames);
/// Returns the frames of a shard of so many chunks, those left out as empty ones; none at all where its index is
/// damaged.
std::vector<std::span<const uint8_t>> split_frames(std::span<const uint8_t> shard, size_t chunks);

/// Size and digest of a shard's file: of a shard that is void, and has none, 0 bytes.
struct ShardDigest {
    uint64_t bytes = 0;
    uint64_t digest = 0;
    bool operator==(const ShardDigest&) const = default;
};

ShardDigest digest_of(std::span<const uint8_t> shard);

}  // namespace openfab::zarr
