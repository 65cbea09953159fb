// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "runtime/nearest/kernel/kernel.h"

namespace openfab::nearest {

/// Exact boxes of patches that have been diced at least once, much tighter than their displacement
/// bounds: a patch pruned by its box is neither looked up in the cache nor diced again. Which boxes
/// are cached never shows in an answer.
class PatchBoxes {
  public:
    /// Makes empty storage for patch ids below `patches`.
    explicit PatchBoxes(size_t patches)
        : count_((patches + BoxPage::kSize - 1) / BoxPage::kSize),
          pages_(std::make_unique<std::atomic<BoxPage*>[]>(count_)) {}
    ~PatchBoxes() {
        for (size_t p = 0; p < count_; ++p)
            delete pages_[p].load(std::memory_order_relaxed);
    }
    PatchBoxes(const PatchBoxes&) = delete;
    PatchBoxes& operator=(const PatchBoxes&) = delete;

    /// Stores the box of a patch, always the same one. From any thread.
    void put(int32_t patch, const Node& box) {
        const auto id = static_cast<size_t>(patch);
        std::atomic<BoxPage*>& slot = pages_[id / BoxPage::kSize];
        BoxPage* page = slot.load(std::memory_order_acquire);
        if (page == nullptr) {
            auto made = std::make_unique<BoxPage>();
            if (slot.compare_exchange_strong(page, made.get(), std::memory_order_acq_rel))
                page = made.release();
        }
        const std::atomic_ref<uint8_t> state(page->state[id % BoxPage::kSize]);
        uint8_t empty = BoxPage::kEmpty;
        if (!state.compare_exchange_strong(empty, BoxPage::kBeingWritten)) return;
        page->box[id % BoxPage::kSize] = box;
        state.store(BoxPage::kReady, std::memory_order_release);
    }

    /// Returns whether the patch's box is stored. From any thread.
    bool has(int32_t patch) const {
        const auto id = static_cast<size_t>(patch);
        BoxPage* page = pages_[id / BoxPage::kSize].load(std::memory_order_acquire);
        if (page == nullptr) return false;
        const std::atomic_ref<uint8_t> state(page->state[id % BoxPage::kSize]);
        return state.load(std::memory_order_relaxed) == BoxPage::kReady;
    }

    /// The pages by patch id, for the kernel.
    const BoxPage* const* pages() const {
        static_assert(sizeof(std::atomic<BoxPage*>) == sizeof(BoxPage*));
        return reinterpret_cast<const BoxPage* const*>(pages_.get());
    }

  private:
    size_t count_;
    std::unique_ptr<std::atomic<BoxPage*>[]> pages_;
};

}  // namespace openfab::nearest
