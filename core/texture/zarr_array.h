// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the metadata of an array of Zarr say, version 2 (`.zarray`, https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html) or
// 3 (`zarr.json`, .../v3/core/index.html): how numbers lie in chunks, and chunks in files. Bytes of chunks are
// tools/texture/zarr_volume.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::texture {

/// What turns bytes into others.
enum class ZarrCodec : uint8_t { kBlosc, kCrc32c, kGzip, kZlib, kZstd };
/// Returns its name in metadata.
const char* codec_name(ZarrCodec codec);

struct ZarrArray {
    std::vector<int64_t> shape;  ///< slowest axis first, as in all lists of axes here
    std::vector<int64_t> file;   ///< sides of what a file holds: a chunk, or a shard
    std::vector<int64_t> chunk;  ///< sides of a chunk
    /// Axes of the array in the order in which a chunk's bytes have them, the slowest first.
    std::vector<size_t> order;
    char kind = 'f';  ///< of its numbers: u, i, f, or b for truth
    int bytes = 4;    ///< of a number
    bool big_endian = false;
    std::array<char, 8> fill{};     ///< the number where there is no chunk, little-endian
    std::vector<ZarrCodec> codecs;  ///< of a chunk's bytes, in the order of writing

    bool sharded = false;
    bool index_first = false;  ///< the index is the begin of a shard, else its end
    bool index_big_endian = false, index_checked = false;  ///< CRC-32C is behind it

    std::string key_begin;  ///< of the names of its files
    char separator = '/';
    std::vector<std::string> names;  ///< of its axes; empty where they have none

    /// Counts the bytes of a chunk as they are decoded.
    int64_t chunk_bytes() const;
    /// Counts the chunks of a shard; 1 without shards.
    int64_t chunks_in_file() const;
    /// Returns the name of a file, from the array's folder on.
    std::string file_name(std::span<const int64_t> at) const;
};

/// Reads `zarr.json` of an array. Errors name what is not taken, with `name` and the line.
Result<ZarrArray> read_zarr3_array(const JsonValue& root, const std::string& name);
/// Reads `.zarray`.
Result<ZarrArray> read_zarr2_array(const JsonValue& root, const std::string& name);

}  // namespace openfab::texture
