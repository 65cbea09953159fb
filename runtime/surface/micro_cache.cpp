// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/surface/micro_cache.h"

#include <algorithm>
#include <utility>

namespace openfab::surface {

namespace {

// A full tile with a few attributes takes about 60 kB; a shard should hold many, or sharding wastes
// the budget.
constexpr size_t kLeastShardBytes = 4u << 20;
constexpr size_t kMostShards = 16;
// List node, map node and the shared_ptr's control block.
constexpr size_t kEntryOverhead = 160;

}  // namespace

MicroCache::MicroCache(size_t budget_bytes) {
    const size_t count = std::clamp<size_t>(budget_bytes / kLeastShardBytes, 1, kMostShards);
    shard_budget_ = budget_bytes / count;
    for (size_t i = 0; i < count; ++i)
        shards_.push_back(std::make_unique<Shard>());
}

std::shared_ptr<const MicroMesh> MicroCache::find(int32_t patch) {
    Shard& shard = shard_of(patch);
    const std::lock_guard lock(shard.mutex);
    const auto place = shard.places.find(patch);
    if (place == shard.places.end()) {
        ++shard.misses;
        return nullptr;
    }
    ++shard.hits;
    shard.entries.splice(shard.entries.begin(), shard.entries, place->second);
    return place->second->mesh;
}

std::shared_ptr<const MicroMesh> MicroCache::insert(int32_t patch,
                                                    std::shared_ptr<const MicroMesh> mesh) {
    const size_t bytes = mesh->bytes() + kEntryOverhead;
    Shard& shard = shard_of(patch);
    // What is evicted is freed after the lock is let go.
    std::list<Entry> dropped;
    const std::lock_guard lock(shard.mutex);
    const auto place = shard.places.find(patch);
    if (place != shard.places.end()) return place->second->mesh;
    if (bytes > shard_budget_) return mesh;
    while (shard.bytes + bytes > shard_budget_) {
        const auto last = std::prev(shard.entries.end());
        shard.bytes -= last->bytes;
        shard.places.erase(last->patch);
        dropped.splice(dropped.end(), shard.entries, last);
        ++shard.evictions;
    }
    shard.entries.push_front({patch, bytes, mesh});
    shard.places.emplace(patch, shard.entries.begin());
    shard.bytes += bytes;
    shard.peak = std::max(shard.peak, shard.bytes);
    return mesh;
}

void MicroCache::count(SurfaceCounts* counts) const {
    for (const auto& shard : shards_) {
        const std::lock_guard lock(shard->mutex);
        counts->cache_hits += shard->hits;
        counts->cache_misses += shard->misses;
        counts->cache_evictions += shard->evictions;
        counts->cache_peak_bytes += static_cast<int64_t>(shard->peak);
    }
}

}  // namespace openfab::surface
