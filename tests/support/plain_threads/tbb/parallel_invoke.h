// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include <functional>

#include "tests/support/plain_threads/tbb/plain.h"

namespace tbb {

template <typename... Tasks>
void parallel_invoke(Tasks&&... tasks) {
    const std::function<void()> all[] = {[&tasks] { tasks(); }...};
    plain::each(sizeof...(Tasks), [&](size_t i) { all[i](); });
}

}  // namespace tbb
