// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the voxels of a print lie in a store: OME-Zarr 0.5, which is Zarr version 3, axes z, y, x.
//
//   zarr.json               the group: multiscales, labels' names and colours, and `openfab`, what the print is
//   0/zarr.json             the array of the codes, uint8, 0 is void; 1, 2, … each half as fine
//   0/c/Z/0/0               a shard: all of x and y, 8 slices. Levels 1, 2 and 3 have the same slabs, of 4, 2
//                           and 1 of their slices; coarser ones have 8 of their own slices a shard. No file: void
//   openfab/zarr.json       an empty group
//   openfab/A-B.list        shards that the writer of slices A to B has finished (shard_list.h): these alone count
//   openfab/complete.lock   empty; who has its lock makes the coarse levels
//   openfab/manifest.json   of a whole print: its hash, its volumes, digests of the shards of coarse levels
//
// A chunk has 128 x 128 voxels and the slices of its shard, compressed by zstd with its checksum; a chunk of void is
// left out.

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::zarr {

constexpr int32_t kSlab = 8;    ///< slices
constexpr int32_t kTile = 128;  ///< voxels of a chunk along x and y
/// Levels that are made with a slab's voxels, the finest included.
constexpr size_t kSlabLevels = 4;
constexpr const char* kGroupFile = "zarr.json";
constexpr const char* kOwnFolder = "openfab";
constexpr const char* kManifestFile = "openfab/manifest.json";
constexpr int64_t kMostJsonBytes = int64_t{16} << 20;

/// An array of the store.
struct Level {
    Vec3i size;
    int32_t depth = kSlab;  ///< slices of a shard and of its chunks

    int32_t shards() const { return (size.z + depth - 1) / depth; }
    int32_t tiles_x() const { return (size.x + kTile - 1) / kTile; }
    int32_t tiles_y() const { return (size.y + kTile - 1) / kTile; }
    size_t chunks() const {
        return static_cast<size_t>(tiles_x()) * static_cast<size_t>(tiles_y());
    }
    size_t chunk_bytes() const { return static_cast<size_t>(depth) * kTile * kTile; }
    /// Returns the most bytes of a shard: zstd adds little to what it cannot compress.
    uint64_t most_shard_bytes() const {
        constexpr uint64_t kAdded = 512 + 16;
        return chunks() * (chunk_bytes() + chunk_bytes() / 128 + kAdded) + 4;
    }
    int64_t plane() const { return int64_t{size.x} * size.y; }
};

/// Returns the levels of a grid: each halves the one before, rounded up, until no side has more than 256 voxels.
std::vector<Level> levels_of(const Vec3i& size);

/// Returns the texts of the group and of an array. They are the same for all parts of a print.
std::string group_json(const pipeline::PrintInfo& info);
std::string array_json(const Level& level);

/// Returns `0/c/7/0/0`.
std::string shard_key(size_t level, int32_t shard);

/// Reads the group: the print, of all its slices. Errors begin with `name`.
Result<pipeline::PrintInfo> read_group(const std::string& text, const std::string& name);
/// Fails where an array is not as array_json makes it of `level`.
Result<void> check_array(const std::string& text, const Level& level, const std::string& name);

}  // namespace openfab::zarr
