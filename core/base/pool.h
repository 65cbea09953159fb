// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Objects that tasks take, use alone and give back.

#include <memory>
#include <mutex>
#include <vector>

namespace openfab {

/// A pool of objects that are used by one task at a time and reused. A task owns what it took until
/// it is done; with thread-local storage, a thread that waits inside a task and runs another would
/// share the object with itself.
template <typename T>
class Pool {
  public:
    template <typename Make>
    T* take(const Make& make) {
        const std::lock_guard lock(mutex_);
        if (free_.empty()) {
            all_.push_back(make());
            return all_.back().get();
        }
        T* object = free_.back();
        free_.pop_back();
        return object;
    }
    void give(T* object) {
        const std::lock_guard lock(mutex_);
        free_.push_back(object);
    }
    /// Returns all objects; none may be taken meanwhile.
    const std::vector<std::unique_ptr<T>>& all() const { return all_; }

  private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> all_;
    std::vector<T*> free_;
};

}  // namespace openfab
