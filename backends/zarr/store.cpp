// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/store.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "backends/common/tee_sink.h"
#include "backends/zarr/messages.h"
#include "base/hash.h"
#include "base/input_file.h"
#include "base/json.h"

namespace openfab::zarr {

namespace fs = std::filesystem;

namespace {

constexpr int64_t kMostListBytes = int64_t{256} << 20;

}  // namespace

bool is_store(const fs::path& path) {
    std::error_code ignored;
    for (const char* file : {kGroupFile, ".zgroup", ".zarray"})
        if (fs::exists(path / file, ignored)) return true;
    return false;
}

std::string identity_of(const std::string& group) {
    return fmt::format("{:016x}", xxh3(group));
}

Result<Store> Store::open(const fs::path& path) {
    Store store;
    store.path_ = path;
    std::error_code ignored;
    if (!fs::exists(path / kGroupFile, ignored)) {
        return user_error(fs::exists(path / ".zgroup", ignored) ||
                                  fs::exists(path / ".zarray", ignored)
                              ? fmt::format(messages::kOtherVersion, path.string(), 2)
                              : fmt::format(messages::kNoStore, path.string()));
    }
    const std::string name = store.name_of(kGroupFile);
    const Result<std::string> group = read_text_file(name, kMostJsonBytes);
    if (!group) return group.error();
    Result<pipeline::PrintInfo> info = read_group(*group, name);
    if (!info) return info.error();
    store.info_ = std::move(*info);
    store.identity_ = identity_of(*group);
    store.levels_ = levels_of(store.info_.size);
    for (size_t level = 0; level < store.levels_.size(); ++level) {
        const std::string array = store.name_of(fmt::format("{}/{}", level, kGroupFile));
        const Result<std::string> text = read_text_file(array, kMostJsonBytes);
        if (!text) return text.error();
        if (Result<void> fine = check_array(*text, store.levels_[level], array); !fine)
            return fine.error();
    }
    return store;
}

size_t Store::slab_levels() const {
    return std::min(levels_.size(), kSlabLevels);
}

int32_t Store::planes_of(size_t level, int32_t shard) const {
    const Level& of = levels_[level];
    return std::min(of.depth, of.size.z - shard * of.depth);
}

Result<std::vector<ShardList>> Store::lists() const {
    std::vector<ShardList> lists;
    std::error_code status;
    for (fs::directory_iterator entry(path_ / kOwnFolder, status), end; !status && entry != end;
         entry.increment(status)) {
        if (entry->path().extension() != ".list") continue;
        const Result<InputFile> file = InputFile::open(entry->path());
        const Result<std::string> text =
            file ? file->read_all(kMostListBytes) : Result<std::string>(file.error());
        if (!text)
            return with_context(text.error(),
                                fmt::format(messages::kCannotRead, entry->path().string()));
        std::optional<ShardList> list = parse_list(*text, identity_, slab_levels());
        if (list && list->end <= info_.size.z) lists.push_back(std::move(*list));
    }
    std::sort(lists.begin(), lists.end(), [](const ShardList& a, const ShardList& b) {
        return std::pair(a.begin, a.end) < std::pair(b.begin, b.end);
    });
    return lists;
}

Result<std::vector<uint8_t>> Store::read_shard(size_t level, int32_t shard,
                                               const ShardDigest& digest) const {
    std::vector<uint8_t> bytes;
    if (digest.bytes == 0) return bytes;
    const std::string key = shard_key(level, shard);
    const Result<InputFile> file = InputFile::open(path_ / key);
    if (!file) return with_context(file.error(), fmt::format(messages::kShardUnread, name_of(key)));
    if (static_cast<uint64_t>(file->bytes()) != digest.bytes) {
        return user_error(
            fmt::format(messages::kShardOtherSize, name_of(key), file->bytes(), digest.bytes));
    }
    if (digest.bytes > levels_[level].most_shard_bytes())
        return user_error(fmt::format(messages::kShardDamaged, name_of(key)));
    bytes.resize(digest.bytes);
    const Result<size_t> read = file->read(0, bytes.data(), bytes.size());
    if (!read) return with_context(read.error(), fmt::format(messages::kShardUnread, name_of(key)));
    if (*read != bytes.size() || digest_of(bytes) != digest)
        return user_error(fmt::format(messages::kShardDiffers, name_of(key)));
    return bytes;
}

Result<void> Store::each_chunk(size_t level, int32_t shard, std::span<const uint8_t> bytes,
                               const Visit& visit) const {
    const Level& of = levels_[level];
    const Error damaged =
        user_error(fmt::format(messages::kShardDamaged, name_of(shard_key(level, shard))));
    const std::vector<std::span<const uint8_t>> frames = split_frames(bytes, of.chunks());
    if (frames.empty()) return damaged;
    std::vector<uint8_t> codes(of.chunk_bytes());
    for (size_t chunk = 0; chunk < frames.size(); ++chunk) {
        if (frames[chunk].empty()) continue;
        if (!decompress_chunk(frames[chunk], codes) || !visit(chunk, codes)) return damaged;
    }
    return {};
}

Result<void> Store::decode(size_t level, int32_t shard, std::span<const uint8_t> bytes,
                           int32_t planes, std::vector<uint8_t>* out) const {
    const Level& of = levels_[level];
    out->assign(static_cast<size_t>(planes) * static_cast<size_t>(of.plane()), 0);
    if (bytes.empty()) return {};
    return each_chunk(level, shard, bytes, [&](size_t chunk, std::span<const uint8_t> codes) {
        const int32_t x = static_cast<int32_t>(chunk % static_cast<size_t>(of.tiles_x())) * kTile;
        const int32_t y = static_cast<int32_t>(chunk / static_cast<size_t>(of.tiles_x())) * kTile;
        const auto width = static_cast<size_t>(std::min(kTile, of.size.x - x));
        const int32_t height = std::min(kTile, of.size.y - y);
        for (int32_t z = 0; z < planes; ++z) {
            for (int32_t row = 0; row < height; ++row) {
                const uint8_t* const from =
                    codes.data() +
                    (static_cast<size_t>(z) * kTile + static_cast<size_t>(row)) * kTile;
                std::copy_n(from, width,
                            out->data() + z * of.plane() + int64_t{y + row} * of.size.x + x);
            }
        }
        return true;
    });
}

Result<void> Store::decode_rows(int32_t shard, std::span<const uint8_t> bytes, int32_t planes,
                                std::vector<uint8_t>* rows) const {
    const Level& of = levels_[0];
    const size_t row_bytes = backends::packed_row_bytes(of.size.x, info_.bits);
    const size_t plane = row_bytes * static_cast<size_t>(of.size.y);
    rows->assign(static_cast<size_t>(planes) * plane, 0);
    if (bytes.empty()) return {};
    const auto most = static_cast<uint8_t>(info_.materials.size());
    return each_chunk(0, shard, bytes, [&](size_t chunk, std::span<const uint8_t> codes) {
        const int32_t x = static_cast<int32_t>(chunk % static_cast<size_t>(of.tiles_x())) * kTile;
        const int32_t y = static_cast<int32_t>(chunk / static_cast<size_t>(of.tiles_x())) * kTile;
        const auto width = static_cast<size_t>(std::min(kTile, of.size.x - x));
        const int32_t height = std::min(kTile, of.size.y - y);
        const size_t at = static_cast<size_t>(x) * static_cast<size_t>(info_.bits) / 8;
        uint8_t highest = 0;
        for (int32_t z = 0; z < planes; ++z) {
            for (int32_t row = 0; row < height; ++row) {
                const std::span<const uint8_t> line = codes.subspan(
                    (static_cast<size_t>(z) * kTile + static_cast<size_t>(row)) * kTile, width);
                for (const uint8_t code : line)
                    highest = std::max(highest, code);
                backends::pack_row(line, info_.bits,
                                   rows->data() + static_cast<size_t>(z) * plane +
                                       static_cast<size_t>(y + row) * row_bytes + at);
            }
        }
        return highest <= most;
    });
}

std::optional<pipeline::PrintTotals> totals_of(const std::vector<ShardList>& lists,
                                               int32_t slices) {
    pipeline::PrintTotals totals;
    int32_t next = 0;
    for (const ShardList& list : lists) {
        if (list.begin != next || !list.totals) return {};
        if (next == 0) {
            totals = *list.totals;
        } else {
            totals.add(*list.totals);
        }
        next = list.end;
    }
    return next == slices ? std::optional(totals) : std::nullopt;
}

}  // namespace openfab::zarr
