// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The outer surface of a volume, where its coverage is one half, as rays meet it.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "tools/render/clearances.h"
#include "tools/render/volume.h"

namespace openfab::render {

/// Positions are in the volume's coordinates, directions in millimetres.
struct Ray {
    Vec3d at;
    Vec3d direction;  ///< unit
    Vec3d step;       ///< voxels per mm along it
    bool inside = false;
};

/// Immutable; one for all threads.
class Skin {
  public:
    /// `volume` must outlive it.
    explicit Skin(const Volume* volume);

    /// Moves a ray outside to the surface that it meets within `most_mm`, or as far; returns false where it meets none.
    bool walk(double most_mm, Ray* ray) const;
    /// Finds where, between two distances in mm, the coverage passes to the other side; returns false where it does not.
    bool find(const Ray& ray, double from, double to, double* where) const;
    double coverage(const Vec3d& at) const;
    Vec3d slope(const Vec3d& at) const;         ///< of coverage per mm, exact in the dual cell
    Vec3d smooth_slope(const Vec3d& at) const;  ///< over a voxel

    const Clearances& clearances() const { return clearances_; }
    const Vec3d& per_mm() const { return per_mm_; }  ///< voxels
    /// From the surface, where a ray goes on: far below a free path.
    double apart_mm() const { return apart_mm_; }

  private:
    /// Returns the millimetres to where a ray from outside enters the box of blocks, or infinity.
    double enter(const Ray& ray) const;

    const Volume& volume_;
    Clearances clearances_;
    /// Whether all of a group, Volume::kGroup blocks wide, is outside: rays pass it in one step.
    std::vector<uint8_t> is_void_;
    Vec3i group_count_;
    Vec3d per_mm_;
    double apart_mm_ = 0;
};

}  // namespace openfab::render
