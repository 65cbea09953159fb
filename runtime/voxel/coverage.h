// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solid voxelisation of one part in one group of 8 slices, in integers, without cracks.
//
// A voxel is inside if the winding number of its centre, moved by an infinitesimal (e, e^2, e^3),
// is above zero; vertices are snapped to floor(256 v + 0.5) in voxel units.

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/patch_index.h"

namespace openfab::voxel {

/// Coverage of 8 slices z0..z0+7 (z0 a multiple of 8) over a rectangle of columns aligned to 8.
/// mask[(y - y0) * stride + (x - x0)]: bit k is set where voxel (x, y, z0 + k) is inside.
struct GroupMask {
    int32_t x0 = 0, y0 = 0;         ///< multiples of 8
    int32_t width = 0, height = 0;  ///< multiples of 8; 0 where the part misses the group
    std::vector<uint8_t> mask;      ///< stride == width
};

/// Voxelises parts group after group. One per part; `coverage` may be called from several threads
/// for different groups.
///
/// A displaced patch that reaches over several groups is diced once: its crossings wait for the
/// later groups, up to `waiting_bytes`; beyond that they are found again. The postcard needs 5 MB.
class Voxeliser {
  public:
    /// `index` is of the surface; without it one is made.
    Voxeliser(const scene::Part& part, const surface::Surface& surface, const scene::Grid& grid,
              size_t waiting_bytes = 16u << 20, std::shared_ptr<const PatchIndex> index = nullptr);
    ~Voxeliser();
    Voxeliser(const Voxeliser&) = delete;
    Voxeliser& operator=(const Voxeliser&) = delete;

    /// Fills `out` for slices [8 group, 8 group + 8); reuses its memory.
    void coverage(int32_t group, GroupMask* out) const;
    /// The part's box in voxels of the grid, hi exclusive, conservative.
    Box3i voxel_box() const;
    /// Memory held now, without surface and index: what set-up made, what waits for later groups.
    size_t bytes() const;

  private:
    struct Impl;
    Impl* impl_;
};

}  // namespace openfab::voxel
