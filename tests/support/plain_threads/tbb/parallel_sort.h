// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// See plain.h. Sorts in this thread.

#include <algorithm>

namespace tbb {

template <typename Iterator>
void parallel_sort(Iterator begin, Iterator end) {
    std::sort(begin, end);
}

template <typename Iterator, typename Less>
void parallel_sort(Iterator begin, Iterator end, const Less& less) {
    std::sort(begin, end, less);
}

}  // namespace tbb
