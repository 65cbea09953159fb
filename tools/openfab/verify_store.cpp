// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/verify_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "backends/read/print_file.h"
#include "backends/zarr/store.h"
#include "backends/zarr/whole_store.h"
#include "base/say.h"
#include "base/text.h"
#include "runtime/pipeline/print_hash.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace fs = std::filesystem;

namespace {

/// Ranges of slices that lists lack, END excluded.
std::vector<std::pair<int32_t, int32_t>> gaps(const std::vector<zarr::ShardList>& lists,
                                              int32_t slices) {
    std::vector<std::pair<int32_t, int32_t>> missing;
    int32_t next = 0;
    for (const zarr::ShardList& list : lists) {
        if (next < list.begin) missing.emplace_back(next, list.begin);
        const int32_t there =
            std::min(list.begin + static_cast<int32_t>(list.slabs.size()) * zarr::kSlab, list.end);
        if (there < list.end || !list.totals) {
            missing.emplace_back(list.begin, list.end);  // as whoever prints them again names them
        }
        next = std::max(next, list.end);
    }
    if (next < slices) missing.emplace_back(next, slices);
    return missing;
}

std::string words_of(const std::vector<std::pair<int32_t, int32_t>>& ranges) {
    std::vector<std::string> words;
    for (const auto& [begin, end] : ranges)
        words.push_back(fmt::format("{}:{}", begin, end));
    return fmt::format("{}", fmt::join(words, ", "));
}

/// Checks one shard's file; a void one has none.
Result<void> check_shard(const zarr::Store& store, size_t level, int32_t shard,
                         const zarr::ShardDigest& digest) {
    if (digest.bytes > 0) {
        const Result<std::vector<uint8_t>> bytes = store.read_shard(level, shard, digest);
        return bytes ? Result<void>() : bytes.error();
    }
    const fs::path file = store.path() / zarr::shard_key(level, shard);
    std::error_code ignored;
    if (!fs::exists(file, ignored)) return {};
    return user_error(fmt::format(messages::kShardOfVoid, file.string()));
}

Result<void> check_coarse(const zarr::Store& store, const zarr::Manifest& manifest) {
    for (size_t level = store.slab_levels(); level < store.levels().size(); ++level) {
        for (int32_t shard = 0; shard < store.levels()[level].shards(); ++shard) {
            const auto digest = manifest.coarse.find(zarr::shard_key(level, shard));
            if (digest == manifest.coarse.end())
                return user_error(
                    fmt::format(messages::kStoreWithoutManifest, store.path().string()));
            if (Result<void> fine = check_shard(store, level, shard, digest->second); !fine)
                return fine;
        }
    }
    return {};
}

}  // namespace

Result<std::string> missing_in_store(const fs::path& path) {
    const Result<zarr::Store> store = zarr::Store::open(path);
    if (!store) return store.error();
    const Result<std::vector<zarr::ShardList>> lists = store->lists();
    if (!lists) return lists.error();
    return words_of(gaps(*lists, store->info().size.z));
}

Result<void> verify_store(const fs::path& path, int64_t memory_bytes) {
    const Result<zarr::Store> store = zarr::Store::open(path);
    if (!store) return store.error();
    const Result<std::vector<zarr::ShardList>> lists = store->lists();
    if (!lists) return lists.error();
    const int32_t slices = store->info().size.z;
    const auto missing = gaps(*lists, slices);
    const auto print = prints::PrintFile::open(path.string(), memory_bytes);
    if (!print) return print.error();
    const auto totals = (*print)->totals();
    // The top and the bottom may be elsewhere, as those of other parts.
    if (!totals)
        return user_error(
            fmt::format(messages::kStoreLacksSlices, path.string(), words_of(missing)));
    const Result<uint64_t> hash = (*print)->hash_of_slices();
    if (!hash) return hash.error();
    if (*hash != totals->hash)
        return user_error(fmt::format(messages::kHashDiffers, path.string(), *hash,
                                      fmt::format("{:016x}", totals->hash)));
    int64_t shards = 0;
    for (const zarr::ShardList& list : *lists) {
        for (size_t slab = 0; slab < list.slabs.size(); ++slab) {
            const int32_t shard = list.begin / zarr::kSlab + static_cast<int32_t>(slab);
            for (size_t level = 0; level < list.slabs[slab].size(); ++level, ++shards) {
                const Result<void> fine =
                    check_shard(*store, level, shard, list.slabs[slab][level]);
                if (!fine) return fine;
            }
        }
    }
    if (missing.empty()) {
        const Result<std::optional<zarr::Manifest>> manifest = zarr::read_manifest(*store);
        if (!manifest) return manifest.error();
        if (!*manifest || (*manifest)->totals.hash != totals->hash)
            return user_error(fmt::format(messages::kStoreWithoutManifest, path.string()));
        if (Result<void> fine = check_coarse(*store, **manifest); !fine) return fine;
        shards += static_cast<int64_t>((*manifest)->coarse.size());
    }
    const pipeline::PrintInfo& info = (*print)->info();
    say(fmt::format(messages::kStoreWhole, printable(path.string()), shards,
                    info.slice_end - info.slice_begin, totals->hash));
    return {};
}

}  // namespace openfab::tools
