// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Solid voxelisation of one part in one slab of 8 slices, in integers, without cracks.
//
// A voxel is inside if the winding number of its center, perturbed by an infinitesimal (e, e^2,
// e^3), is above zero; vertices are snapped to floor(256 v + 0.5) in voxel units.

#include <atomic>
#include <cstdint>
#include <memory>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"
#include "runtime/voxel/patch_index.h"
#include "runtime/voxel/slab_mask.h"

namespace openfab::voxel {

/// Voxelises one part slab by slab. `coverage` may be called from several threads for different
/// slabs.
///
/// A displaced patch that spans several slabs is diced once: its crossings wait for the later
/// slabs, up to `waiting_bytes`; beyond that they are computed again. The postcard needs 5 MB.
class Voxeliser {
  public:
    /// Sets up; `index` is that of the surface, or null to make one.
    Voxeliser(const part::Part& part, const surface::Surface& surface, const part::Grid& grid,
              size_t waiting_bytes = 16u << 20, std::shared_ptr<const PatchIndex> index = nullptr);
    ~Voxeliser();
    Voxeliser(const Voxeliser&) = delete;
    Voxeliser& operator=(const Voxeliser&) = delete;

    /// Computes the coverage of slices [8 slab, 8 slab + 8) into `out`, reusing its memory. Once
    /// `stop` is set, it ends soon, and what is in `out` is of no use. Adds to `seconds` what it took,
    /// of the threads that helped, too, but not what this one waited for them.
    void coverage(int32_t slab, SlabMask* out, const std::atomic<bool>* stop = nullptr,
                  double* seconds = nullptr) const;
    /// Drops the crossings that wait for later slabs; call while no other thread uses it.
    void drop_waiting() const;
    /// Returns the part's conservative box in voxels of the grid, hi exclusive.
    Box3i voxel_box() const;
    /// Returns the bytes held now: by set-up and by waiting crossings, without surface and index.
    size_t bytes() const;

  private:
    struct Impl;
    Impl* impl_;
};

}  // namespace openfab::voxel
