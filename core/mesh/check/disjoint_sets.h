// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A union-find structure over 0 to n - 1; each set is represented by its lowest number.

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/large_pages.h"

namespace openfab::mesh {

class DisjointSets {
  public:
    explicit DisjointSets(size_t n) : parent_(large_vector<int32_t>(n)) {
        std::iota(parent_.begin(), parent_.end(), 0);
    }

    size_t size() const { return parent_.size(); }
    /// Returns the lowest number of the set that contains `i`.
    int32_t find(int32_t i) {
        while (parent(i) != i) {
            parent(i) = parent(parent(i));
            i = parent(i);
        }
        return i;
    }
    void join(int32_t a, int32_t b) {
        a = find(a), b = find(b);
        parent(std::max(a, b)) = std::min(a, b);
    }

  private:
    int32_t& parent(int32_t i) { return parent_[i]; }

    std::vector<int32_t> parent_;
};

}  // namespace openfab::mesh
