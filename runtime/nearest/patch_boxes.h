// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "runtime/nearest/kernel.h"

namespace openfab::nearest {

/// The boxes of patches that have been diced once, much closer than those that hold whatever a
/// patch may become: a patch that is too far by its box is not looked for in the cache, nor made
/// again. Which boxes are known never shows in an answer.
class PatchBoxes {
  public:
    /// For patch ids below `patches`.
    explicit PatchBoxes(size_t patches)
        : count_((patches + BoxPage::kSize - 1) / BoxPage::kSize),
          pages_(std::make_unique<std::atomic<BoxPage*>[]>(count_)) {}
    ~PatchBoxes() {
        for (size_t p = 0; p < count_; ++p)
            delete pages_[p].load(std::memory_order_relaxed);
    }
    PatchBoxes(const PatchBoxes&) = delete;
    PatchBoxes& operator=(const PatchBoxes&) = delete;

    /// Any thread; `box` is always the same for a patch.
    void put(int32_t patch, const Node& box) {
        const auto id = static_cast<size_t>(patch);
        std::atomic<BoxPage*>& place = pages_[id / BoxPage::kSize];
        BoxPage* page = place.load(std::memory_order_acquire);
        if (page == nullptr) {
            auto made = std::make_unique<BoxPage>();
            if (place.compare_exchange_strong(page, made.get(), std::memory_order_acq_rel))
                page = made.release();
        }
        const std::atomic_ref<uint8_t> state(page->state[id % BoxPage::kSize]);
        uint8_t unknown = BoxPage::kUnknown;
        if (!state.compare_exchange_strong(unknown, BoxPage::kBeingWritten)) return;
        page->box[id % BoxPage::kSize] = box;
        state.store(BoxPage::kKnown, std::memory_order_release);
    }

    const BoxPage* const* pages() const {
        static_assert(sizeof(std::atomic<BoxPage*>) == sizeof(BoxPage*));
        return reinterpret_cast<const BoxPage* const*>(pages_.get());
    }

  private:
    size_t count_;
    std::unique_ptr<std::atomic<BoxPage*>[]> pages_;
};

}  // namespace openfab::nearest
