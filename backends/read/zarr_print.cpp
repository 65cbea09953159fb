// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/zarr_print.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "backends/common/tee_sink.h"
#include "backends/read/messages.h"
#include "base/json.h"

namespace openfab::prints {

Result<std::unique_ptr<PrintFile>> ZarrPrint::open(const std::string& path, int64_t memory_bytes) {
    Result<zarr::Store> store = zarr::Store::open(path);
    if (!store) return store.error();
    const Result<std::vector<zarr::ShardList>> lists = store->lists();
    if (!lists) return lists.error();
    std::unique_ptr<ZarrPrint> print(new ZarrPrint(path, std::move(*store)));
    print->info_ = print->store_.info();
    if (!lists->empty()) {
        print->info_.slice_begin = lists->front().begin;
        print->info_.slice_end = lists->back().end;
    }
    print->row_bytes_ = backends::packed_row_bytes(print->info_.size.x, print->info_.bits);
    // The slices of a slab, and its shard.
    if (Result<void> fits =
            print->check_memory((zarr::kSlab + 2) * print->slice_bytes(), memory_bytes);
        !fits)
        return fits.error();
    print->take_lists(*lists);
    return std::unique_ptr<PrintFile>(std::move(print));
}

bool ZarrPrint::take_lists(const std::vector<zarr::ShardList>& lists) {
    std::vector<zarr::ShardDigest> shards;
    pipeline::PrintTotals totals;
    totals.complete = true;
    int32_t next = info_.slice_begin;
    bool all = true;
    for (const zarr::ShardList& list : lists) {
        if (list.begin != next) break;
        for (const std::vector<zarr::ShardDigest>& slab : list.slabs)
            shards.push_back(slab.front());
        all = list.totals.has_value();
        if (!all) break;
        if (next == info_.slice_begin) totals = *list.totals;
        if (next != info_.slice_begin) totals.add(*list.totals);
        next = list.end;
    }
    const std::lock_guard lock(mutex_);
    const bool found = shards.size() > shards_.size();
    shards_ = std::move(shards);
    if (!all || next != info_.slice_end || next == info_.slice_begin) return found;
    totals.voxels_by_code.resize(info_.materials.size() + 1);
    const bool is_new = !totals_;
    totals_ = std::move(totals);
    return found || is_new;
}

int32_t ZarrPrint::whole_slices() const {
    const std::lock_guard lock(mutex_);
    return std::min(static_cast<int32_t>(shards_.size()) * zarr::kSlab,
                    info_.slice_end - info_.slice_begin);
}

std::optional<pipeline::PrintTotals> ZarrPrint::totals() const {
    const std::lock_guard lock(mutex_);
    return totals_;
}

bool ZarrPrint::look_again() {
    const Result<std::vector<zarr::ShardList>> lists = store_.lists();
    return lists && take_lists(*lists);
}

bool ZarrPrint::was_replaced() const {
    const Result<std::string> group =
        read_text_file(store_.path() / zarr::kGroupFile, zarr::kMostJsonBytes);
    return group && zarr::identity_of(*group) != store_.identity();
}

Result<void> ZarrPrint::read_slice(int32_t z, SliceBuffers* buffers) const {
    const int32_t shard = z / zarr::kSlab;
    zarr::ShardDigest digest;
    {
        const std::lock_guard lock(mutex_);
        const auto place = static_cast<size_t>(shard - info_.slice_begin / zarr::kSlab);
        if (z < info_.slice_begin || z >= info_.slice_end || place >= shards_.size())
            return error(fmt::format(messages::kSliceNotThere, z));
        digest = shards_[place];
    }
    const auto plane = static_cast<size_t>(slice_bytes());
    if (digest.bytes == 0) {
        buffers->rows.assign(plane, 0);
        return {};
    }
    const int32_t planes = store_.planes_of(0, shard);
    // What has the digest is the same, wherever it is from, as long as its planes are as large.
    if (buffers->slab_digest != digest.digest ||
        buffers->slab.size() != static_cast<size_t>(planes) * plane) {
        buffers->slab_digest = 0;
        const Result<std::vector<uint8_t>> bytes = store_.read_shard(0, shard, digest);
        if (!bytes) return bytes.error();
        const Result<void> decoded = store_.decode_rows(shard, *bytes, planes, &buffers->slab);
        if (!decoded) return decoded;
        buffers->slab_digest = digest.digest;
    }
    const auto from = static_cast<std::ptrdiff_t>(static_cast<size_t>(z % zarr::kSlab) * plane);
    buffers->rows.assign(buffers->slab.begin() + from,
                         buffers->slab.begin() + from + static_cast<std::ptrdiff_t>(plane));
    return {};
}

}  // namespace openfab::prints
