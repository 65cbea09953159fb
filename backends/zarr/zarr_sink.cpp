// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/zarr_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <system_error>
#include <utility>

#include "backends/common/messages.h"
#include "backends/common/resume_check.h"
#include "backends/common/tee_sink.h"
#include "backends/zarr/messages.h"
#include "backends/zarr/shard.h"
#include "backends/zarr/slab.h"
#include "backends/zarr/store.h"
#include "backends/zarr/whole_store.h"
#include "base/check.h"
#include "base/json.h"
#include "base/units.h"

namespace openfab::zarr {

namespace fs = std::filesystem;

namespace {

/// Returns the name of a file in a folder that another program has; empty where there is none.
std::string other_file(const fs::path& folder) {
    std::error_code status;
    for (fs::directory_iterator entry(folder, status), end; !status && entry != end;
         entry.increment(status)) {
        std::string name = entry->path().filename().string();
        if (!name.ends_with(".part")) return name;  // of one that was killed while it began
    }
    return {};
}

/// Removes what a killed writer has left of a shard that it had not finished.
void remove_parts(const fs::path& folder) {
    std::error_code status;
    std::vector<fs::path> parts;
    for (fs::directory_iterator entry(folder, status), end; !status && entry != end;
         entry.increment(status))
        if (entry->path().extension() == ".part") parts.push_back(entry->path());
    for (const fs::path& part : parts)
        fs::remove(part, status);
}

/// Returns what differs between the print of a group's text and `info`.
std::string difference(const std::string& text, const std::string& name,
                       const pipeline::PrintInfo& info) {
    const Result<pipeline::PrintInfo> there = read_group(text, name);
    if (!there) return there.error().text();
    pipeline::PrintInfo here = info;
    here.slice_begin = 0;
    here.slice_end = info.size.z;
    const std::string found = backends::first_difference(*there, here);
    return found.empty() ? std::string(messages::kOtherPrintUnknown) : found;
}

}  // namespace

Result<void> ZarrSink::make_store() {
    std::error_code status;
    if (fs::exists(path_, status) && !fs::is_directory(path_, status))
        return user_error(fmt::format(messages::kOutputIsFile, path_.string()));
    const fs::path group = path_ / kGroupFile;
    const std::string text = group_json(info_);
    if (!fs::exists(group, status)) {
        if (const std::string other = other_file(path_); !other.empty() && !fs::exists(group))
            return user_error(fmt::format(messages::kOtherFiles, path_.string(), other));
    }
    const Result<bool> claimed = fs::exists(group, status) ? false : claim_store_file(group, text);
    if (!claimed) return claimed.error();
    if (!*claimed) {
        const Result<std::string> there = read_text_file(group, kMostJsonBytes);
        if (!there) return there.error();
        if (*there != text) {
            const std::string why = difference(*there, group.string(), info_);
            return resume_ ? backends::resume_refused(path_.string(), why)
                           : user_error(fmt::format(messages::kOtherPrint, path_.string(), why));
        }
    }
    for (size_t level = 0; level < levels_.size(); ++level) {
        const fs::path array = path_ / std::to_string(level) / kGroupFile;
        if (Result<void> made = write_store_file(array, array_json(levels_[level])); !made)
            return made;
    }
    // A group, so that other programs know what to make of it.
    constexpr std::string_view kOwnGroup =
        R"({"zarr_format": 3, "node_type": "group", "attributes": {}})";
    return write_store_file(path_ / kOwnFolder / kGroupFile, kOwnGroup);
}

Result<void> ZarrSink::begin_list() {
    const fs::path file = path_ / list_name(info_.slice_begin, info_.slice_end);
    const Result<Store> store = Store::open(path_);
    if (!store) return store.error();
    const auto is_ours = [&](const ShardList& there) {
        return there.begin == info_.slice_begin && there.end == info_.slice_end;
    };
    Result<std::vector<ShardList>> lists = store->lists();
    if (!lists) return lists.error();
    for (const ShardList& there : *lists) {
        if (is_ours(there) || there.begin >= info_.slice_end || info_.slice_begin >= there.end)
            continue;
        return user_error(fmt::format(
            messages::kOthersSlices, info_.slice_begin, info_.slice_end, path_.string(),
            (path_ / list_name(there.begin, there.end)).string(), there.begin, there.end));
    }
    Result<ListFile> list = ListFile::open(file);
    if (!list) return list.error();
    // Now that no other process writes it.
    if (resume_) lists = store->lists();
    if (!lists) return lists.error();
    for (ShardList& there : *lists)
        if (resume_ && is_ours(there)) earlier_ = std::move(there);
    list_.emplace(std::move(*list));
    if (earlier_) return {};
    if (Result<void> gone = remove_store_file(path_ / kManifestFile); !gone) return gone;
    if (Result<void> cut = list_->cut(0); !cut) return cut;
    return list_->add(list_head(identity_, info_.slice_begin, info_.slice_end));
}

Result<void> ZarrSink::begin(const pipeline::PrintInfo& info) {
    const int32_t begin = info.slice_begin / kSlab * kSlab;
    const int32_t end = std::min((info.slice_end + kSlab - 1) / kSlab * kSlab, info.size.z);
    if (begin != info.slice_begin || end != info.slice_end)
        return usage_error(
            fmt::format(messages::kNotAtSlabs, info.slice_begin, info.slice_end, begin, end));
    info_ = info;
    levels_ = levels_of(info.size);
    identity_ = identity_of(group_json(info));
    if (Result<void> made = make_store(); !made) return made;
    return begin_list();
}

Result<int32_t> ZarrSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!earlier_) return 0;
    const ShardList earlier = std::move(*earlier_);
    earlier_.reset();
    const Result<Store> store = Store::open(path_);
    if (!store) return store.error();
    const size_t row_bytes = backends::packed_row_bytes(info_.size.x, info_.bits);
    const size_t plane = row_bytes * static_cast<size_t>(info_.size.y);
    std::string kept = list_head(identity_, info_.slice_begin, info_.slice_end);
    std::vector<uint8_t> rows;
    for (const std::vector<ShardDigest>& slab : earlier.slabs) {
        const int32_t shard = next_slab(), planes = store->planes_of(0, shard);
        Result<std::vector<uint8_t>> bytes = std::vector<uint8_t>();
        for (size_t level = slab.size(); level > 0 && bytes; --level)
            bytes = store->read_shard(level - 1, shard, slab[level - 1]);
        if (!bytes || !store->decode_rows(shard, *bytes, planes, &rows)) break;
        for (int32_t z = 0; z < planes; ++z) {
            if (!show({shard * kSlab + z, rows.data() + static_cast<size_t>(z) * plane, row_bytes,
                       info_.size.x, info_.size.y})) {
                list_.reset();
                return Error{ErrorCode::kInterrupted,
                             fmt::format(backends::messages::kInterruptedReading, path_.string())};
            }
        }
        kept += slab_line(shard, slab);
        bytes_ += bytes->size();
        ++slabs_;
    }
    for (size_t level = 0; level < std::min(levels_.size(), kSlabLevels); ++level)
        remove_parts((path_ / shard_key(level, next_slab())).parent_path());
    const bool all = slabs_ * kSlab >= info_.slice_end - info_.slice_begin;
    ended_ = all && earlier.totals.has_value();
    if (!ended_) {
        if (Result<void> gone = remove_store_file(path_ / kManifestFile); !gone)
            return gone.error();
        if (Result<void> cut = list_->cut(kept.size()); !cut) return cut.error();
    }
    return std::min(slabs_ * kSlab, info_.slice_end - info_.slice_begin);
}

std::vector<uint8_t> ZarrSink::encode(const pipeline::SliceView& slice) const {
    return split_tiles(slice, info_.bits);
}

Error ZarrSink::with_resume_state(const Error& error) const {
    const int32_t slices = slabs_ * kSlab;
    std::string message = fmt::format(backends::messages::kWholeSlicesBefore, error.text(), slices);
    const double left = info_.slice_end - info_.slice_begin - slices;
    if (slices > 0 && left > 0) {
        const double bytes = static_cast<double>(bytes_) / slices * left;
        message +=
            fmt::format(backends::messages::kRestTakes, format_bytes(static_cast<int64_t>(bytes)));
    }
    return {error.code, std::move(message)};
}

Result<void> ZarrSink::write_slab() {
    const std::span<const Level> levels(levels_.data(), std::min(levels_.size(), kSlabLevels));
    const Result<std::vector<std::vector<uint8_t>>> shards =
        make_shards(waiting_, levels, info_.bits);
    waiting_.clear();
    if (!shards) return shards.error();
    const int32_t slab = next_slab();
    std::vector<ShardDigest> digests;
    for (size_t level = 0; level < shards->size(); ++level) {
        const std::vector<uint8_t>& shard = (*shards)[level];
        const std::string key = shard_key(level, slab);
        const Result<void> written =
            shard.empty() ? remove_store_file(path_ / key) : write_store_file(path_ / key, shard);
        if (!written) return written;
        digests.push_back(digest_of(shard));
        bytes_ += shard.size();
    }
    if (Result<void> added = list_->add(slab_line(slab, digests)); !added) return added;
    ++slabs_;
    return {};
}

Result<void> ZarrSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    OPENFAB_CHECK_EQ(z, next_slab() * kSlab + static_cast<int32_t>(waiting_.size()));
    waiting_.push_back(std::move(bytes));
    if (waiting_.size() < kSlab && z + 1 < info_.slice_end) return {};
    Result<void> written = write_slab();
    if (written) return {};
    broken_ = true;
    return with_resume_state(written.error());
}

Result<void> ZarrSink::finish(const pipeline::PrintTotals& totals) {
    waiting_.clear();
    const bool all = slabs_ * kSlab >= info_.slice_end - info_.slice_begin;
    if (!list_ || broken_ || !totals.complete || !all) return {};
    if (!ended_) {
        if (Result<void> synced = list_->sync(); !synced) return synced;
        if (Result<void> added = list_->add(end_line(totals)); !added) return added;
    }
    list_.reset();
    return complete_store(path_);
}

}  // namespace openfab::zarr
