// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h. Arenas bound nothing: the global limit does.

#include "tests/support/plain_threads/tbb/plain.h"

namespace tbb {

class task_arena {
  public:
    explicit task_arena(int /*threads*/) {}
    template <typename Work>
    auto execute(const Work& work) {
        return work();
    }
};

namespace this_task_arena {

/// A thread that waits takes no other work here.
template <typename Work>
auto isolate(const Work& work) {
    return work();
}

inline int max_concurrency() {
    return plain::allowed.load();
}

}  // namespace this_task_arena
}  // namespace tbb
