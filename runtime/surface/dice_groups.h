// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Groups of small patches that are diced together. Where a base triangle has few micro-edges, as in a
// draft, setting up the surface kernel and an entry of the cache cost more than its points.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/surface/surface.h"

namespace openfab::surface {

/// The groups of one surface: neighbours in space, each patch of kind kLattice in one at most.
class DiceGroups {
  public:
    DiceGroups() = default;
    DiceGroups(const std::vector<Patch>& patches, double micro_edge_mm);

    /// Returns the patches that are diced with one, itself among them: just the patch if it is in no
    /// group. `patch` stays valid as long as the span.
    std::span<const int32_t> of(const int32_t& patch) const {
        const uint32_t group = groups_.empty() ? kNone : groups_[static_cast<size_t>(patch)];
        if (group == kNone) return {&patch, 1};
        return {order_.data() + first_[group], first_[group + 1] - first_[group]};
    }

  private:
    static constexpr uint32_t kNone = UINT32_MAX;

    std::vector<uint32_t> groups_;  ///< [patch], or empty where there are none
    std::vector<int32_t> order_;    ///< patches, group after group
    std::vector<uint32_t> first_{0};
};

}  // namespace openfab::surface
