// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Arena for trees that live as long as the engine: their arrays lie side by side, in the order in
// which they were first needed. A query of a dense mesh reads a few hundred locations in some dozen
// arrays.

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "runtime/nearest/tree/hierarchy.h"

namespace openfab::nearest {

/// Stores trees contiguously.
class TreeStore {
  public:
    /// Copies the tree; the view is valid as long as the store. From any thread. Throws
    /// std::bad_alloc.
    TreeView keep(const Tree& tree);

  private:
    struct alignas(64) Line {
        std::byte bytes[64];
    };
    template <typename T>
    const T* copy(const std::vector<T>& values);
    Line* take(size_t lines);

    std::mutex mutex_;
    std::vector<std::unique_ptr<Line[]>> regions_;
    Line* next_ = nullptr;  ///< of the last region
    size_t left_ = 0;       ///< lines
};

}  // namespace openfab::nearest
