// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Work side by side without a pool: the threads of one are not there in a forked child (jail.h).

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <system_error>
#include <thread>
#include <vector>

#include "base/allowance.h"

namespace openfab {

/// Calls `work(i)` for each i below `count`, on as many threads as there are processors. Where no thread can be made, one
/// does all.
template <typename Work>
void on_own_threads(size_t count, const Work& work) {
    std::atomic<size_t> next{0};
    const auto take = [&] {
        for (size_t i = next++; i < count; i = next++)
            work(i);
    };
    const size_t most = std::min(count, static_cast<size_t>(usable_cores()));
    std::vector<std::thread> threads;
    try {
        for (size_t t = 1; t < most; ++t)
            threads.emplace_back(take);
    } catch (const std::system_error&) {
        // The work goes on with those that there are.
    }
    take();
    for (std::thread& thread : threads)
        thread.join();
}

}  // namespace openfab
