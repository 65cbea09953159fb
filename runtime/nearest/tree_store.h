// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory for trees that stay until the end: their arrays lie side by side, in the order in which
// they were first needed, on large pages where there are many. A query of a dense mesh reads a few
// hundred places of some dozen arrays, more pages of 4 KiB than a processor keeps addresses of.

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "runtime/nearest/hierarchy.h"

namespace openfab::nearest {

class TreeStore {
  public:
    /// For trees that will take about so much together.
    explicit TreeStore(size_t expected_bytes);

    /// A copy of the tree, whose view is valid as long as the store. From any thread. Throws
    /// std::bad_alloc.
    TreeView keep(const Tree& tree);

  private:
    struct Free {
        void operator()(std::byte* region) const;
    };
    template <typename T>
    const T* copy(const std::vector<T>& values);
    std::byte* take(size_t bytes);

    const bool large_pages_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<std::byte, Free>> regions_;
    std::byte* next_ = nullptr;  ///< of the last region
    size_t left_ = 0;
};

}  // namespace openfab::nearest
