// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small hierarchies of diced patches, made when a query first needs them, kept under a byte budget,
// least recently used out first. What is in the cache never shows in an answer.

#include <atomic>
#include <memory>
#include <vector>

#include "base/lru_cache.h"
#include "runtime/nearest/chunks.h"
#include "runtime/nearest/hierarchy.h"
#include "runtime/nearest/patch_boxes.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

struct PatchTree {
    Tree tree;
    TreeView view;  ///< nodes null where the patch has no triangle

    size_t bytes() const { return tree.bytes(); }
};

void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out);

/// Trees of displaced patches, of any number of surfaces: what one does not need just now, another
/// may have.
class PatchCache {
    // A tree of a full tile takes about 100 kB.
    static constexpr size_t kShardBytes = 8u << 20;

  public:
    explicit PatchCache(size_t budget_bytes) : trees_(budget_bytes, kShardBytes) {}
    /// While one thread alone uses it.
    void set_budget(size_t bytes) { trees_.set_budget(bytes); }
    void set_most_pinned(size_t bytes) { most_pinned_ = bytes; }
    size_t most_pinned() const { return most_pinned_; }
    /// For a surface that is new, here or in any other cache.
    static int32_t join() {
        static std::atomic<int32_t> joined{0};
        return ++joined;
    }
    /// Any thread. Two threads may build one patch at the same time; both get the same tree in the
    /// end, unless it is larger than the cache. `surface_id` as of join().
    std::shared_ptr<const PatchTree> get(const surface::Surface& surface, int32_t surface_id,
                                         int32_t patch);

  private:
    LruCache<uint64_t, PatchTree> trees_;  ///< surface_id, patch
    size_t most_pinned_ = kMostPinnedBytes;
};

/// Where the trees of one surface come from.
struct TreeSources {
    PatchCache* cache;
    const surface::Surface* surface;
    int32_t surface_id;  ///< as of PatchCache::join()
    const Chunks* chunks;
    PatchBoxes* boxes;
};

/// The patches that one call of a kernel needs, held until its end at least, so that its pointers
/// stay good; and longer while they are few (kHeldPatchBytes), as the next call mostly needs the
/// same.
///
/// No more bytes than PatchCache::most_pinned() are held, unless `all` are asked for: then patches
/// come back empty, and what the kernel says means nothing. Whoever called it asks for less at a
/// time.
class PatchPins {
  public:
    /// Before a call.
    void begin(const TreeSources& sources, bool all = false);
    /// After it: false where patches were left out.
    bool end();
    /// PatchSource::fetch; `context` is a PatchPins. `id` is a patch or a chunk, which needs no
    /// pin.
    static const TreeView* fetch(void* context, int32_t id);

  private:
    const TreeView* pin(int32_t patch);
    void let_go();
    void rehash(size_t slots);

    TreeSources sources_{};
    std::vector<std::pair<int32_t, std::shared_ptr<const PatchTree>>> pins_;
    size_t bytes_ = 0;       // of those
    size_t most_bytes_ = 0;  // that they may have in this call
    bool left_out_ = false;
    std::vector<int32_t> table_;  // place in pins_ + 1; power of two, at most half full
};

}  // namespace openfab::nearest
