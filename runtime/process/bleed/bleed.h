// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Drops spread before they set. With fractions f of the materials, void among them, and a point spread
// G of each pair, what comes out has
//
//     B f_a = f_a + sum over b of (f_b G_ab * f_a - f_a G_ab * f_b),
//
// which is G * f_a where all pairs have the same spread; each pair exchanges as much as it gets, so
// that no volume changes. It is undone before the dither by fixed-point steps, g := g + f - B g, each kept
// within what a voxel can hold. A voxel depends on nothing but those within reach, so that slabs, rows
// and runs of blocks may be computed in any order.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "runtime/dither/band.h"
#include "runtime/process/bleed/bleed_window.h"

namespace openfab::process {

/// The bands around a row of blocks: [dz][dy], of the slabs and rows within reach; null: all void.
struct NearBands {
    struct One {
        const dither::RowBand* band = nullptr;
        const std::vector<uint64_t>* present = nullptr;  ///< of Bleed::find_present
    };
    std::vector<One> bands;
    int32_t slab = 0;  ///< of the middle one
    int32_t row = 0;
};

/// What one thread needs to compute a row.
struct BleedScratch {
    BleedWindow window;
    std::vector<uint64_t> present;
};

class Bleed {
  public:
    /// At most that many voxels are within reach along an axis.
    static constexpr int32_t kMostReach = 32;

    /// `undo_steps`: 0 does not undo it. `show`: the fractions become those that come out.
    Bleed(std::vector<PairSpread> pairs, int32_t undo_steps, bool show);

    /// Returns how far voxels change each other along each axis.
    const Vec3i& reach() const { return reach_; }
    Vec3i reach_blocks() const;
    /// Whether voxels that were void may get material.
    bool leaves_parts() const { return leaves_parts_; }

    /// Finds which materials each block of a band has that bleed, as bits.
    void find_present(const dither::RowBand& band, std::vector<uint64_t>* present) const;
    /// Sets `out` to the middle band with its fractions changed. `size` of the grid in voxels.
    void apply(const NearBands& near, const Vec3i& size, BleedScratch* scratch,
               dither::RowBand* out) const;
    /// Returns the bytes of a BleedScratch.
    int64_t scratch_bytes() const;

  private:
    /// The bit of a channel in what find_present finds; 0: it does not bleed.
    uint64_t bit_of(int32_t channel) const;
    bool may_change(uint64_t present) const;
    Vec2<int32_t> present_around(const NearBands& near, std::vector<uint64_t>* around) const;
    void load(const NearBands& near, const Vec3i& size, const Vec3i& lowest,
              BleedWindow* window) const;
    void store(const BleedWindow& window, const Vec3i& lowest, const Vec2<int32_t>& blocks,
               const Vec3i& slab_size, dither::RowBand* out) const;

    BleedKernels kernels_;
    std::vector<int32_t> place_;  ///< by channel: its place among those that bleed, or -1
    std::vector<uint64_t> pair_bits_;
    int32_t undo_steps_;
    bool show_, leaves_parts_ = false;
    Vec3i reach_;
};

}  // namespace openfab::process
