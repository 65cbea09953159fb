// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Threads of the standard library behind the names of TBB that we use, for builds under the thread sanitizer
// (OPENFAB_SANITIZE=thread): distributions' TBB is not instrumented, so the sanitizer sees none of its hand-overs and reports each.
// Here a loop begins and ends by what it knows: threads that start and are joined, and mutexes. Indices of a loop are handed out
// by atomics that order nothing, so that one body is not taken to come before another because it happened to. As in TBB, how a
// loop is divided is not said, and loops may stand in loops; unlike there, threads are not kept.

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace tbb {

/// Marks the constructor that makes a second body of a reduction.
class split {};
/// Gives each grain a task of its own, as all loops have here.
class simple_partitioner {};

namespace plain {

/// Threads that a loop may have, its own included.
inline std::atomic<int> allowed{8};
/// Threads that were started for loops and are not joined yet.
inline std::atomic<int> started{0};
constexpr int kMostStarted = 16;

/// Returns whether the caller may start a thread; `give` takes it back.
inline bool take_thread() {
    if (started.fetch_add(1, std::memory_order_relaxed) < kMostStarted) return true;
    started.fetch_sub(1, std::memory_order_relaxed);
    return false;
}
inline void give_thread() {
    started.fetch_sub(1, std::memory_order_relaxed);
}

/// Calls work() in up to `most` threads at once, this one among them, and returns when all have.
template <typename Work>
void in_threads(size_t most, const Work& work) {
    std::vector<std::thread> threads;
    const size_t limit = static_cast<size_t>(allowed.load(std::memory_order_relaxed));
    while (threads.size() + 1 < most && threads.size() + 1 < limit && take_thread())
        threads.emplace_back([&work] { work(); });
    work();
    for (std::thread& thread : threads) {
        thread.join();
        give_thread();
    }
}

/// Calls visit(i) for each i below `count`, once, in any thread.
template <typename Visit>
void each(size_t count, const Visit& visit) {
    std::atomic<size_t> next{0};
    in_threads(count, [&] {
        for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;)
            visit(i);
    });
}

}  // namespace plain
}  // namespace tbb
