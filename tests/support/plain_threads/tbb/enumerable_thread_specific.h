// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <thread>

namespace tbb {

template <typename T>
class enumerable_thread_specific {
  public:
    explicit enumerable_thread_specific(std::function<T()> make) : make_(std::move(make)) {}
    T& local() {
        const std::lock_guard<std::mutex> lock(mutex_);
        T*& own = of_[std::this_thread::get_id()];
        if (own == nullptr) own = &values_.emplace_back(make_());
        return *own;
    }
    auto begin() const { return values_.begin(); }
    auto end() const { return values_.end(); }

  private:
    std::mutex mutex_;
    std::function<T()> make_;
    std::list<T> values_;
    std::map<std::thread::id, T*> of_;
};

}  // namespace tbb
