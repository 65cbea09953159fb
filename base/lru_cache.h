// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/check.h"

namespace openfab {

/// Least recently used cache of values by key, never more bytes than the budget. A value that is
/// evicted while somebody holds it lives on, outside the budget. Sharded by key, so that threads
/// seldom wait for each other; all functions are thread-safe.
///
/// Holds only what can be recomputed: a hit or a miss never changes a result.
template <typename Key, typename Value>
class LruCache {
  public:
    struct Counts {
        int64_t hits = 0, misses = 0, evictions = 0, peak_bytes = 0;
        int64_t inserted_bytes = 0;  ///< of all values so far, evicted or not
    };

    /// `shard_bytes`: a shard should hold many values, or sharding wastes the budget.
    LruCache(size_t budget_bytes, size_t shard_bytes) {
        OPENFAB_CHECK_GT(shard_bytes, 0u);
        const size_t count = std::clamp<size_t>(budget_bytes / shard_bytes, 1, kMostShards);
        shard_budget_ = budget_bytes / count;
        for (size_t i = 0; i < count; ++i)
            shards_.push_back(std::make_unique<Shard>());
    }

    /// Sets the budget and evicts what exceeds it; no other thread may use the cache meanwhile.
    void set_budget(size_t bytes) {
        shard_budget_ = bytes / shards_.size();
        std::list<Entry> dropped;
        for (const auto& shard : shards_)
            make_room(shard.get(), 0, &dropped);
    }

    /// Returns the value, or null.
    std::shared_ptr<const Value> find(const Key& key) {
        Shard& shard = shard_of(key);
        const std::lock_guard lock(shard.mutex);
        const auto found = shard.index.find(key);
        if (found == shard.index.end()) {
            ++shard.counts.misses;
            return nullptr;
        }
        ++shard.counts.hits;
        shard.entries.splice(shard.entries.begin(), shard.entries, found->second);
        return found->second->value;
    }

    /// Inserts the value, of value->bytes(), if it fits. Where another thread was first, its value
    /// is returned and this one dropped.
    std::shared_ptr<const Value> insert(const Key& key, std::shared_ptr<const Value> value) {
        OPENFAB_DCHECK(value != nullptr);
        const size_t bytes = value->bytes() + kEntryOverhead;
        Shard& shard = shard_of(key);
        // Evicted values are freed after the lock is released.
        std::list<Entry> dropped;
        const std::lock_guard lock(shard.mutex);
        const auto found = shard.index.find(key);
        if (found != shard.index.end()) return found->second->value;
        if (bytes > shard_budget_) return value;
        make_room(&shard, bytes, &dropped);
        shard.entries.push_front({key, bytes, value});
        shard.index.emplace(key, shard.entries.begin());
        shard.bytes += bytes;
        shard.counts.inserted_bytes += static_cast<int64_t>(bytes);
        shard.counts.peak_bytes =
            std::max(shard.counts.peak_bytes, static_cast<int64_t>(shard.bytes));
        return value;
    }

    Counts counts() const {
        Counts sum;
        for (const auto& shard : shards_) {
            const std::lock_guard lock(shard->mutex);
            sum.hits += shard->counts.hits;
            sum.misses += shard->counts.misses;
            sum.evictions += shard->counts.evictions;
            sum.peak_bytes += shard->counts.peak_bytes;
            sum.inserted_bytes += shard->counts.inserted_bytes;
        }
        return sum;
    }

  private:
    static constexpr size_t kMostShards = 16;
    // List node, map node and the shared_ptr's control block.
    static constexpr size_t kEntryOverhead = 160;

    struct Entry {
        Key key;
        size_t bytes;
        std::shared_ptr<const Value> value;
    };
    struct Shard {
        mutable std::mutex mutex;
        std::list<Entry> entries;  ///< most recent first
        std::unordered_map<Key, typename std::list<Entry>::iterator> index;
        size_t bytes = 0;
        Counts counts;
    };

    Shard& shard_of(const Key& key) { return *shards_[static_cast<size_t>(key) % shards_.size()]; }

    void make_room(Shard* shard, size_t bytes, std::list<Entry>* dropped) {
        while (shard->bytes + bytes > shard_budget_) {
            OPENFAB_CHECK(!shard->entries.empty());
            const auto last = std::prev(shard->entries.end());
            shard->bytes -= last->bytes;
            shard->index.erase(last->key);
            dropped->splice(dropped->end(), shard->entries, last);
            ++shard->counts.evictions;
        }
    }

    size_t shard_budget_;
    std::vector<std::unique_ptr<Shard>> shards_;
};

}  // namespace openfab
