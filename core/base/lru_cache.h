// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/check.h"

namespace openfab {

/// What becomes of values that are larger than a shard's share of the budget.
enum class LargeValues {
    kAreNotKept,
    kAreKeptAlone,  ///< in their shards, beyond the budget, until another comes
};

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
    LruCache(size_t budget_bytes, size_t shard_bytes, LargeValues large = LargeValues::kAreNotKept)
        : large_(large) {
        OPENFAB_CHECK_GT(shard_bytes, 0u);
        const size_t count = std::clamp<size_t>(budget_bytes / shard_bytes, 1, kMostShards);
        shard_budget_ = budget_bytes / count;
        for (size_t i = 0; i < count; ++i)
            shards_.push_back(std::make_unique<Shard>());
    }

    /// Sets the budget and evicts what exceeds it; no other thread may use the cache meanwhile.
    void set_budget(size_t bytes) {
        shard_budget_ = bytes / shards_.size();
        Dropped dropped;
        for (const auto& shard : shards_)
            make_room(shard.get(), 0, &dropped);
    }

    /// Begins a period, and evicts what was not used in the last `periods` before it. From any thread.
    void begin_period(int64_t periods) {
        Dropped dropped;
        for (const auto& shard : shards_) {
            const std::lock_guard lock(shard->mutex);
            ++shard->period;
            while (shard->used > 0 &&
                   shard->entries[shard->entries[kEnds].last].period + periods < shard->period)
                evict_oldest(shard.get(), &dropped);
        }
    }

    /// Returns the value, or null.
    std::shared_ptr<const Value> find(const Key& key) {
        Shard& shard = shard_of(key);
        const std::lock_guard lock(shard.mutex);
        const uint32_t entry = shard.table[slot_of(shard, key)];
        if (entry == kNone) {
            ++shard.counts.misses;
            return nullptr;
        }
        ++shard.counts.hits;
        shard.entries[entry].period = shard.period;
        if (shard.entries[kEnds].next != entry) {
            unlink(&shard, entry);
            link_first(&shard, entry);
        }
        return shard.entries[entry].value;
    }

    /// Inserts the value, of value->bytes(), if it fits. Where another thread was first, its value
    /// is returned and this one dropped.
    std::shared_ptr<const Value> insert(const Key& key, std::shared_ptr<const Value> value) {
        OPENFAB_DCHECK(value != nullptr);
        const size_t bytes = value->bytes() + kEntryOverhead;
        Shard& shard = shard_of(key);
        // Evicted values are freed after the lock is released.
        Dropped dropped;
        const std::lock_guard lock(shard.mutex);
        const uint32_t found = shard.table[slot_of(shard, key)];
        if (found != kNone) return shard.entries[found].value;
        if (bytes > shard_budget_ && large_ == LargeValues::kAreNotKept) return value;
        make_room(&shard, bytes, &dropped);
        if (2 * (shard.used + 1) > shard.table.size()) rehash(&shard);
        const uint32_t entry = take_entry(&shard);
        shard.entries[entry].key = key;
        shard.entries[entry].bytes = bytes;
        shard.entries[entry].period = shard.period;
        shard.entries[entry].value = value;
        link_first(&shard, entry);
        shard.table[slot_of(shard, key)] = entry;
        ++shard.used;
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
    // The entry, its share of the table and the shared_ptr's control block.
    static constexpr size_t kEntryOverhead = 96;
    static constexpr uint32_t kNone = UINT32_MAX;
    static constexpr uint32_t kEnds =
        0;  ///< its next is the most recent entry, its last the oldest

    using Dropped = std::vector<std::shared_ptr<const Value>>;
    struct Entry {
        Key key{};
        size_t bytes = 0;
        int64_t period = 0;  ///< in which it was used last
        std::shared_ptr<const Value> value;
        uint32_t last = kEnds, next = kEnds;  ///< towards more and less recent ones
    };
    struct Shard {
        mutable std::mutex mutex;
        std::vector<Entry> entries = std::vector<Entry>(1);
        std::vector<uint32_t> free;  ///< entries not in use
        /// Entries by key, open addressing with linear probing; at most half full.
        std::vector<uint32_t> table = std::vector<uint32_t>(64, kNone);
        size_t used = 0;
        size_t bytes = 0;
        int64_t period = 0;
        Counts counts;
    };

    Shard& shard_of(const Key& key) { return *shards_[static_cast<size_t>(key) % shards_.size()]; }

    static size_t home_of(const Shard& shard, const Key& key) {
        const uint64_t hash = static_cast<uint64_t>(key) * 0x9e3779b97f4a7c15u;
        return static_cast<size_t>(hash >> 32) & (shard.table.size() - 1);
    }
    /// Returns the slot of the table that has the key, or the empty one where it would be.
    static size_t slot_of(const Shard& shard, const Key& key) {
        const size_t mask = shard.table.size() - 1;
        size_t slot = home_of(shard, key);
        while (shard.table[slot] != kNone && !(shard.entries[shard.table[slot]].key == key))
            slot = (slot + 1) & mask;
        return slot;
    }
    static void rehash(Shard* shard) {
        std::vector<uint32_t> old(2 * shard->table.size(), kNone);
        old.swap(shard->table);
        for (const uint32_t entry : old) {
            if (entry != kNone) shard->table[slot_of(*shard, shard->entries[entry].key)] = entry;
        }
    }
    /// Empties a slot, and moves back what was pushed on by it.
    static void empty_slot(Shard* shard, size_t slot) {
        const size_t mask = shard->table.size() - 1;
        for (size_t next = (slot + 1) & mask; shard->table[next] != kNone;
             next = (next + 1) & mask) {
            const size_t home = home_of(*shard, shard->entries[shard->table[next]].key);
            if (((next - home) & mask) < ((next - slot) & mask)) continue;
            shard->table[slot] = shard->table[next];
            slot = next;
        }
        shard->table[slot] = kNone;
    }

    static uint32_t take_entry(Shard* shard) {
        if (shard->free.empty()) {
            shard->entries.emplace_back();
            return static_cast<uint32_t>(shard->entries.size() - 1);
        }
        const uint32_t entry = shard->free.back();
        shard->free.pop_back();
        return entry;
    }
    static void link_first(Shard* shard, uint32_t entry) {
        Entry& ends = shard->entries[kEnds];
        shard->entries[entry].last = kEnds;
        shard->entries[entry].next = ends.next;
        shard->entries[ends.next].last = entry;
        shard->entries[kEnds].next = entry;
    }
    static void unlink(Shard* shard, uint32_t entry) {
        const Entry& e = shard->entries[entry];
        shard->entries[e.last].next = e.next;
        shard->entries[e.next].last = e.last;
    }

    void make_room(Shard* shard, size_t bytes, Dropped* dropped) {
        while (shard->used > 0 && shard->bytes + bytes > shard_budget_)
            evict_oldest(shard, dropped);
    }
    static void evict_oldest(Shard* shard, Dropped* dropped) {
        const uint32_t oldest = shard->entries[kEnds].last;
        Entry& entry = shard->entries[oldest];
        shard->bytes -= entry.bytes;
        empty_slot(shard, slot_of(*shard, entry.key));
        unlink(shard, oldest);
        dropped->push_back(std::move(entry.value));
        shard->free.push_back(oldest);
        --shard->used;
        ++shard->counts.evictions;
    }

    const LargeValues large_;
    size_t shard_budget_;
    std::vector<std::unique_ptr<Shard>> shards_;
};

}  // namespace openfab
