// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Units of small diced patches. Where a base triangle has few micro-edges, as in a draft, its patch
// has few micropolygons; then neighbouring patches have one tree together, one leaf in the
// hierarchy over the surface, and one entry in caches.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "runtime/nearest/tree/hierarchy.h"
#include "runtime/surface/surface.h"

namespace openfab::nearest {

/// The units of one surface. A unit's id is that of one of its patches.
class PatchUnits {
  public:
    /// Groups the patches of `boxes`, which are replaced by the boxes of units. The order of the
    /// others stays.
    PatchUnits(const surface::Surface& surface, std::vector<InputPatch>* boxes);

    /// The patches of a unit, neighbours after each other: just the patch if it is in no unit.
    /// `id` stays valid as long as the span.
    std::span<const int32_t> patches(const int32_t& id) const {
        const uint32_t unit = units_.empty() ? kNone : units_[static_cast<size_t>(id)];
        if (unit == kNone) return {&id, 1};
        return {order_.data() + first_[unit], first_[unit + 1] - first_[unit]};
    }
    /// Frees the corners that `boxes` points to.
    void release_input() { corners_ = {}; }

  private:
    static constexpr uint32_t kNone = UINT32_MAX;

    InputPatch box_of(std::span<const int32_t> unit, std::array<Vec3f, 8>* corners) const;

    const std::vector<surface::Patch>& all_;
    std::vector<uint32_t> units_;  ///< [patch]: its unit, kNone unless it is the unit's id
    std::vector<int32_t> order_;   ///< patches, unit after unit
    std::vector<uint32_t> first_{0};
    std::vector<std::array<Vec3f, 8>> corners_;
};

}  // namespace openfab::nearest
