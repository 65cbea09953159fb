// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Squares of distances between the voxels of a box, exact and in linear time: along x, then y, then z.

#include <array>
#include <cstdint>
#include <vector>

#include "tools/inspection/bits.h"

namespace openfab::inspection {

/// Squares of lengths up to a reach, as whole numbers below kFar. Of voxels that are cubes they are exact up to
/// 89 of them, else they are off by 1/60000 of the reach's.
class Squares {
  public:
    static constexpr uint16_t kFar = 0x7fff;

    Squares(const Vec3d& pitch_mm, double reach_mm);

    /// The least number of a square that is not below that of a length.
    uint16_t from(double mm) const;
    double length(uint16_t square) const;

    /// Between voxel centres; or from voxel centres to the places half a voxel behind them along the axes where
    /// `half` is 1, or back from those where it is -1.
    void spread(Box<uint16_t>* values, const Vec3i& half = {}) const;

  private:
    /// By the number of voxels between two places along an axis, from -steps to steps.
    std::vector<uint16_t> costs(int axis, int32_t half) const;

    Vec3d pitch_mm_;
    double unit_mm2_;
    Vec3i steps_;
};

}  // namespace openfab::inspection
