// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A store of a print, read: its texts, the lists of its finished shards, and shards, each checked by its digest.

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "backends/zarr/layout.h"
#include "backends/zarr/shard_list.h"

namespace openfab::zarr {

/// Returns whether a folder is a store of Zarr, of whatever version.
bool is_store(const std::filesystem::path& path);

class Store {
  public:
    /// Opens a store and checks what its arrays say of themselves. Errors name the file.
    static Result<Store> open(const std::filesystem::path& path);

    const std::filesystem::path& path() const { return path_; }
    /// Of the print, with all of its slices.
    const pipeline::PrintInfo& info() const { return info_; }
    const std::string& identity() const { return identity_; }
    const std::vector<Level>& levels() const { return levels_; }
    /// Returns the number of levels that each slab has shards of.
    size_t slab_levels() const;

    /// Reads the lists of this print, in order of their first slices.
    Result<std::vector<ShardList>> lists() const;

    /// Reads a shard's file; no bytes for one that is void. Fails where it is not what the digest says.
    Result<std::vector<uint8_t>> read_shard(size_t level, int32_t shard,
                                            const ShardDigest& digest) const;
    /// Decodes a shard, `planes` of it, to codes, one a byte; `out` has the planes of the level.
    Result<void> decode(size_t level, int32_t shard, std::span<const uint8_t> bytes, int32_t planes,
                        std::vector<uint8_t>* out) const;
    /// As `decode`, of the finest level, to packed rows.
    Result<void> decode_rows(int32_t shard, std::span<const uint8_t> bytes, int32_t planes,
                             std::vector<uint8_t>* rows) const;
    /// Returns the slices of a shard: fewer at the top.
    int32_t planes_of(size_t level, int32_t shard) const;

  private:
    using Visit = std::function<bool(size_t chunk, std::span<const uint8_t> codes)>;
    Result<void> each_chunk(size_t level, int32_t shard, std::span<const uint8_t> bytes,
                            const Visit& visit) const;
    std::string name_of(const std::string& key) const { return (path_ / key).string(); }

    std::filesystem::path path_;
    pipeline::PrintInfo info_;
    std::string identity_;
    std::vector<Level> levels_;
};

/// Returns the identity of the print whose group has the text.
std::string identity_of(const std::string& group);

/// Returns the totals of the whole grid where the lists, in order, are complete and cover it without a gap.
std::optional<pipeline::PrintTotals> totals_of(const std::vector<ShardList>& lists, int32_t slices);

}  // namespace openfab::zarr
