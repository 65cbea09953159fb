// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/at.h"

namespace openfab::inspection {

/// Numbers from 0 on that are united to sets.
class Sets {
  public:
    int32_t add() {
        parent_.push_back(static_cast<int32_t>(parent_.size()));
        return parent_.back();
    }
    int32_t find(int32_t i) {
        while (at(parent_, i) != i) {
            int32_t& up = at(parent_, i);
            up = at(parent_, up);
            i = up;
        }
        return i;
    }
    /// The lowest number of a set names it.
    void unite(int32_t a, int32_t b) {
        a = find(a), b = find(b);
        if (a != b) at(parent_, std::max(a, b)) = std::min(a, b);
    }
    size_t size() const { return parent_.size(); }

  private:
    std::vector<int32_t> parent_;
};

}  // namespace openfab::inspection
