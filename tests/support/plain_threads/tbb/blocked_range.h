// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include <cstddef>

#include "tests/support/plain_threads/tbb/plain.h"

namespace tbb {

template <typename T>
class blocked_range {
  public:
    blocked_range(T begin, T end, size_t grain = 1) : begin_(begin), end_(end), grain_(grain) {}
    T begin() const { return begin_; }
    T end() const { return end_; }
    bool empty() const { return !(begin_ < end_); }
    size_t size() const { return empty() ? 0 : static_cast<size_t>(end_ - begin_); }
    size_t grainsize() const { return grain_; }

  private:
    T begin_, end_;
    size_t grain_;
};

namespace plain {

/// Calls visit(range) for parts of the range, each of a grain or more and at most 64 of them unless `fine`.
template <typename T, typename Visit>
void each_part(const blocked_range<T>& range, bool fine, const Visit& visit) {
    if (range.empty()) return;
    size_t step = range.grainsize();
    if (!fine && step < (range.size() + 63) / 64) step = (range.size() + 63) / 64;
    each((range.size() + step - 1) / step, [&](size_t i) {
        const size_t end = (i + 1) * step < range.size() ? (i + 1) * step : range.size();
        visit(blocked_range<T>(range.begin() + static_cast<T>(i * step),
                               range.begin() + static_cast<T>(end), range.grainsize()));
    });
}

}  // namespace plain
}  // namespace tbb
