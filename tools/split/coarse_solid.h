// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A coarse solid of voxels, for the search for cuts.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "pieces/extent.h"

namespace openfab::pieces {

class CoarseSolid {
  public:
    /// About `voxels` of the box of the body.
    CoarseSolid(const Body& body, int64_t voxels);

    double pitch_mm() const { return pitch_; }
    /// The centres of solid voxels.
    const std::vector<Vec3f>& centers() const { return centers_; }
    /// By voxel: whether a neighbour is not solid.
    const std::vector<uint8_t>& skin() const { return skin_; }
    bool solid(const Vec3d& p) const;

  private:
    size_t index(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y)) *
                   static_cast<size_t>(size_.x) +
               static_cast<size_t>(x);
    }
    Vec3d origin_;
    Vec3i size_;
    double pitch_ = 1;
    std::vector<uint8_t> cells_;
    std::vector<Vec3f> centers_;
    std::vector<uint8_t> skin_;
};

}  // namespace openfab::pieces
