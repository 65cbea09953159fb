// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h.

#include <type_traits>

#include "tests/support/plain_threads/tbb/blocked_range.h"

namespace tbb {

template <typename T, typename Body>
void parallel_for(const blocked_range<T>& range, const Body& body) {
    plain::each_part(range, false, body);
}

template <typename T, typename Body>
void parallel_for(const blocked_range<T>& range, const Body& body,
                  const simple_partitioner& /*fine*/) {
    plain::each_part(range, true, body);
}

template <typename Index, typename Body>
requires std::is_integral_v<Index>
void parallel_for(Index begin, Index end, const Body& body) {
    if (begin < end)
        plain::each(static_cast<size_t>(end - begin),
                    [&](size_t i) { body(static_cast<Index>(begin + static_cast<Index>(i))); });
}

}  // namespace tbb
