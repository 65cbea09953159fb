// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Small hierarchies of diced patches, made when a query first needs them, kept under a byte budget,
// least recently used out first. What is in the cache never shows in an answer.

#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "runtime/nearest/hierarchy.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

struct PatchTree {
    Tree tree;
    TreeView view;  ///< nodes null where the patch has no triangle
};

void append_triangles(const surface::MicroMesh& mesh, int32_t patch,
                      std::vector<InputTriangle>* out);

class PatchCache {
  public:
    PatchCache(const surface::Surface& surface, size_t budget_bytes)
        : surface_(surface), budget_(budget_bytes) {}
    /// Any thread. Two threads may build one patch at the same time; both get the same tree in the
    /// end.
    std::shared_ptr<const PatchTree> get(int32_t patch);

  private:
    struct Slot {
        int32_t patch;
        std::shared_ptr<const PatchTree> tree;
    };
    const surface::Surface& surface_;
    const size_t budget_;
    std::mutex mutex_;
    std::list<Slot> recent_;  // front: used last
    std::unordered_map<int32_t, std::list<Slot>::iterator> places_;
    size_t bytes_ = 0;
};

/// The patches that one block needs, held until the next block, so that the kernel's pointers stay
/// good.
class PatchPins {
  public:
    void reset(PatchCache* cache);
    /// PatchSource::fetch; `context` is a PatchPins.
    static const TreeView* fetch(void* context, int32_t patch);

  private:
    void rehash(size_t slots);

    PatchCache* cache_ = nullptr;
    std::vector<std::pair<int32_t, std::shared_ptr<const PatchTree>>> pins_;
    std::vector<int32_t> table_;  // place in pins_ + 1; power of two, at most half full
};

}  // namespace openfab::nearest
