// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// LRU cache of the small trees of diced patches, built when a query first needs them, under a byte
// budget. Answers do not depend on what is cached.

#include <atomic>
#include <memory>
#include <vector>

#include "base/lru_cache.h"
#include "runtime/nearest/engine/patch_boxes.h"
#include "runtime/nearest/engine/patch_tree.h"
#include "runtime/nearest/tree/patch_units.h"
#include "runtime/nearest/tree/treelets.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// Caches trees of displaced patches of any number of surfaces, under one budget.
class PatchCache {
    // The trees of a full tile take about 100 kB together.
    static constexpr size_t kShardBytes = 8u << 20;

  public:
    explicit PatchCache(size_t budget_bytes) : trees_(budget_bytes, kShardBytes) {}
    /// Changes a limit; call while no other thread uses the cache.
    void set_budget(size_t bytes) { trees_.set_budget(bytes); }
    /// Drops trees that none of the last `periods` asked for, and begins a new one.
    void begin_period(int64_t periods) { trees_.begin_period(periods); }
    void set_max_pinned(size_t bytes) { max_pinned_ = bytes; }
    /// Returns the bytes of all trees that were built so far.
    int64_t built_bytes() const { return trees_.counts().inserted_bytes; }
    size_t max_pinned() const { return max_pinned_; }
    /// Returns a surface id that is new in this and any other cache.
    static int32_t new_surface_id() {
        static std::atomic<int32_t> last{0};
        return ++last;
    }
    /// Returns a tree of a patch or piece, which `make` builds if it is not cached. From any
    /// thread; two threads may build the same one at once, and both get the same tree unless it is
    /// larger than the cache. `surface_id` is from new_surface_id().
    template <typename Make>
    std::shared_ptr<const PatchTree> get(int32_t surface_id, int32_t id, const Make& make) {
        const uint64_t key = static_cast<uint64_t>(surface_id) << 32 | static_cast<uint32_t>(id);
        if (std::shared_ptr<const PatchTree> found = trees_.find(key)) return found;
        return trees_.insert(key, make());
    }

  private:
    LruCache<uint64_t, PatchTree> trees_;  ///< surface_id, id of a patch or piece
    size_t max_pinned_ = kMaxPinnedBytes;
};

/// The sources of the trees of one surface.
struct TreeSources {
    PatchCache* cache;
    const surface::Surface* surface;
    int32_t surface_id;  ///< from PatchCache::new_surface_id()
    const LazyTreelets* treelets;
    const PatchUnits* units;
    PatchBoxes* boxes;
    PieceIds pieces;
    bool crowded = false;  ///< patches are cut at once: their trees will not stay cached
};

/// Pins the patches that one kernel call needs until it ends, so that its pointers stay valid; and
/// longer while they are few (kHeldPatchBytes), as the next call mostly needs the same.
///
/// Pins at most PatchCache::max_pinned() bytes unless `all`: beyond that patches come back empty,
/// the results of the call are invalid, and the caller must repeat it in smaller parts.
class PatchPins {
  public:
    /// Begins a call.
    void begin(const TreeSources& sources, bool all = false);
    /// Ends the call; returns false if patches were left out.
    bool end();
    /// PatchSource::fetch: returns the tree of a patch or of a piece of a patch that is pinned,
    /// which it pins, or of a treelet, which needs no pin. `context` is a PatchPins.
    static const TreeView* fetch(void* context, int32_t id);

  private:
    const TreeView* pin(int32_t id);
    /// Returns the slot of an id in table_: its own, or the empty one where it would go.
    size_t slot_of(int32_t id) const;
    /// Gets a tree from the cache.
    std::shared_ptr<const PatchTree> get(int32_t id);
    void release();
    void rehash(size_t slots);

    TreeSources sources_{};
    LatticeTreeBuilder builder_;
    std::vector<std::pair<int32_t, std::shared_ptr<const PatchTree>>> pins_;
    size_t bytes_ = 0;      // of the pinned trees
    size_t max_bytes_ = 0;  // their limit in this call
    bool left_out_ = false;
    std::vector<int32_t> table_;  // index in pins_ + 1; power of two, at most half full
};

}  // namespace openfab::nearest
