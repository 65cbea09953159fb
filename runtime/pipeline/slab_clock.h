// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which slabs are being made, and since when: for whoever watches a print that says nothing.

#include <cstdint>
#include <list>
#include <mutex>
#include <optional>

#include "base/clock.h"

namespace openfab::pipeline {

/// Thread-safe; it is locked twice a slab.
class SlabClock {
  public:
    struct Slab {
        int32_t first = 0, end = 0;  ///< slices
        double began_seconds = 0;    ///< seconds_now
    };

    /// Lists a slab during its own lifetime; `clock` may be null.
    class Running {
      public:
        Running(SlabClock* clock, int32_t first, int32_t end) : clock_(clock) {
            if (clock_ == nullptr) return;
            const std::lock_guard lock(clock_->mutex_);
            at_ = clock_->slabs_.insert(clock_->slabs_.end(), {first, end, seconds_now()});
        }
        ~Running() {
            if (clock_ == nullptr) return;
            const std::lock_guard lock(clock_->mutex_);
            clock_->slabs_.erase(at_);
        }
        Running(const Running&) = delete;
        Running& operator=(const Running&) = delete;

      private:
        SlabClock* clock_;
        std::list<Slab>::iterator at_;
    };

    /// Returns the slab that has taken longest so far; none while none is made.
    std::optional<Slab> oldest() const {
        const std::lock_guard lock(mutex_);
        if (slabs_.empty()) return {};
        return slabs_.front();
    }

  private:
    mutable std::mutex mutex_;
    std::list<Slab> slabs_;  ///< in the order in which they began
};

}  // namespace openfab::pipeline
