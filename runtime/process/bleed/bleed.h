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

#include "base/pool.h"
#include "base/vec.h"
#include "runtime/dither/band.h"
#include "runtime/process/bleed/bleed_window.h"
#include "runtime/process/effect.h"

namespace openfab::process {

/// What one thread needs to compute a row.
struct BleedScratch {
    BleedWindow window;
    std::vector<uint64_t> present;
};

class Bleed : public Effect {
  public:
    /// At most that many voxels are within reach along an axis.
    static constexpr int32_t kMostReach = 32;

    /// `undo_steps`: 0 does not undo it. `show`: the fractions become those that come out.
    Bleed(std::vector<PairSpread> pairs, int32_t undo_steps, bool show);

    /// A rule of a fablet has chosen before mixtures are there that bleed could be undone in.
    Result<void> begin(const EffectGrid& grid) override;
    Vec3i reach() const override { return reach_; }
    bool leaves_parts() const override { return leaves_parts_; }
    /// Notes which materials each block has that bleed, as bits.
    void note(const dither::RowBand& band, std::vector<uint64_t>* notes) const override;
    void spread(const NearBands& near, const Vec3i& size, dither::RowBand* out) const override;
    int64_t spread_bytes() const override;

  private:
    /// The bit of a channel in what find_present finds; 0: it does not bleed.
    uint64_t bit_of(int32_t channel) const;
    bool may_change(uint64_t present) const;
    Vec2<int32_t> present_around(const NearBands& near, std::vector<uint64_t>* around) const;
    void apply(const NearBands& near, const Vec3i& size, BleedScratch* scratch,
               dither::RowBand* out) const;
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
    mutable Pool<BleedScratch> scratches_;
};

}  // namespace openfab::process
