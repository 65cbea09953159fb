// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The micropolygon cache: patch -> micropolygons, least recently used out first, never more bytes
// than its budget. Entries that somebody still holds live on until they are let go, outside the
// budget.
//
// Sharded by patch, so that threads seldom wait for each other. What is found in it never changes
// an answer: an entry is what the dicer would make again.

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "runtime/surface/surface.h"

namespace openfab::surface {

class MicroCache {
  public:
    explicit MicroCache(size_t budget_bytes);

    std::shared_ptr<const MicroMesh> find(int32_t patch);
    /// Keeps the mesh if it fits. Where another thread was first, its mesh is returned and this one
    /// dropped.
    std::shared_ptr<const MicroMesh> insert(int32_t patch, std::shared_ptr<const MicroMesh> mesh);
    /// Adds hits, misses, evictions and the peak to `counts`.
    void count(SurfaceCounts* counts) const;

  private:
    struct Entry {
        int32_t patch;
        size_t bytes;
        std::shared_ptr<const MicroMesh> mesh;
    };
    struct Shard {
        mutable std::mutex mutex;
        std::list<Entry> entries;  ///< most recent first
        std::unordered_map<int32_t, std::list<Entry>::iterator> places;
        size_t bytes = 0, peak = 0;
        int64_t hits = 0, misses = 0, evictions = 0;
    };

    Shard& shard_of(int32_t patch) { return *shards_[static_cast<size_t>(patch) % shards_.size()]; }

    size_t shard_budget_;
    std::vector<std::unique_ptr<Shard>> shards_;
};

}  // namespace openfab::surface
