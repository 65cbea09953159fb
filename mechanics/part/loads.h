// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Forces on nodes.

#include <span>
#include <vector>

#include "mechanics/part/surface.h"
#include "mechanics/solver/element_operator.h"

namespace openfab::mechanics {

class LoadAssembler {
  public:
    /// Adds to `forces_N`, which outlives it.
    LoadAssembler(const Grid& grid, Field<double, kElastic>* forces_N)
        : grid_(grid), forces_(*forces_N) {}

    /// Spreads a load over faces by their area. A torque becomes forces that grow with the distance from
    /// its axis through the middle of the faces, so that it has no resultant. Fails where the faces are
    /// on one line and cannot take it.
    Result<void> add(const Load& load, std::span<const Face> faces);
    /// Weight of all elements, of densities in g/cm3.
    void add_gravity(const Vec3& m_s2, const Voxels& voxels);
    Vec3 total() const { return total_; }
    /// Nodes with loads of faces, sorted.
    std::vector<int64_t> nodes();

  private:
    void add_to(int64_t node, const Vec3& force_N);

    const Grid& grid_;
    Field<double, kElastic>& forces_;
    Vec3 total_{};
    std::vector<int64_t> nodes_;
};

}  // namespace openfab::mechanics
