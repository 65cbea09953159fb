// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Forces on nodes.

#include <span>
#include <vector>

#include "mechanics/part/pieces.h"
#include "mechanics/solver/element_operator.h"

namespace openfab::mechanics {

class LoadAssembler {
  public:
    /// Adds to `forces_N`, which outlives it. `held` are degrees of freedom that do not move, sorted.
    LoadAssembler(const Grid& grid, Field<double, kElastic>* forces_N,
                  std::span<const Held> held = {})
        : grid_(grid), held_(held), forces_(*forces_N) {}

    /// Spreads a load over faces by their area of material. A torque becomes forces that grow with the distance from
    /// its axis through the middle of the faces, so that it has no resultant. Fails where the faces are
    /// on one line and cannot take it.
    Result<void> add(const Load& load, std::span<const LoadedFace> faces);
    /// Weight of all elements, of densities in g/cm3.
    void add_gravity(const Vec3& m_s2, const Voxels& voxels);
    Vec3 total() const { return total_; }
    /// Of the last load of faces: the share of its forces that acts on what is not held.
    double free_share() const { return acts_ > 0 ? free_ / acts_ : 1; }
    /// Of the last load of faces: its greatest force on a face by the face's area.
    double most_MPa() const { return most_MPa_; }
    /// Nodes with loads of faces, sorted.
    std::vector<int64_t> nodes();

  private:
    void add_to(int64_t node, const Vec3& force_N);

    void count(int64_t node, const Vec3& force_N);

    const Grid& grid_;
    std::span<const Held> held_;
    Field<double, kElastic>& forces_;
    double acts_ = 0, free_ = 0, most_MPa_ = 0;
    Vec3 total_{};
    std::vector<int64_t> nodes_;
};

}  // namespace openfab::mechanics
