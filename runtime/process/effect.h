// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a machine does to voxels, or what is done against it: an effect changes the bands of a print before
// they are dithered, or their codes afterwards. Effects on neighbours come first, then those of single
// voxels, each in the order of the table (kinds/kinds.cpp).

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/dither/band.h"
#include "runtime/process/effect_change.h"

namespace openfab::process {

/// The grid of a print that is set up.
struct EffectGrid {
    Vec3d origin_mm, pitch_mm;
    Vec3i size;
    std::string ruled_fablet;  ///< the first with a dither rule of its own; empty: none
};

/// The bands around a row of blocks: [dz][dy], of the slabs and rows within reach; null: all void.
struct NearBands {
    struct One {
        const dither::RowBand* band = nullptr;
        const std::vector<uint64_t>* notes = nullptr;  ///< of Effect::note
    };
    std::vector<One> bands;
    int32_t slab = 0;  ///< of the middle one
    int32_t row = 0;
};

/// An effect on single voxels as it is for some slices. It stays as it is.
class SliceEffect {
  public:
    virtual ~SliceEffect() = default;
    /// Changes the voxels of slab `slab`. `height` of the grid in voxels.
    virtual void before_dither(int32_t slab, int32_t height, dither::RowBand* band) const = 0;
    /// Changes the codes of a band that is dithered and has got its support.
    virtual void after_dither(int32_t slab, int32_t height, dither::RowBand* band) const = 0;
};
using SliceEffects = std::vector<std::shared_ptr<const SliceEffect>>;

class Effect {
  public:
    virtual ~Effect() = default;

    /// Called when the grid is known, before any slice.
    virtual Result<void> begin(const EffectGrid& grid) = 0;

    /// Returns how far voxels change each other along each axis; 0: this is no effect on neighbours.
    virtual Vec3i reach() const { return {}; }
    Vec3i reach_blocks() const {
        const Vec3i voxels = reach();
        return {(voxels.x + 7) / 8, (voxels.y + 7) / 8, (voxels.z + 7) / 8};
    }
    bool spreads() const { return reach() != Vec3i{}; }
    /// Whether voxels that were void may get material.
    virtual bool leaves_parts() const { return false; }
    /// Notes of a band what `spread` asks of those around: a number for each block.
    virtual void note(const dither::RowBand& /*band*/, std::vector<uint64_t>* /*notes*/) const {}
    /// Sets `out` to the middle band with its fractions changed. `size` of the grid in voxels.
    virtual void spread(const NearBands& /*near*/, const Vec3i& /*size*/,
                        dither::RowBand* /*out*/) const {}
    /// Returns the memory for one call of `spread`.
    virtual int64_t spread_bytes() const { return 0; }

    /// Whether it is one on single voxels.
    virtual bool changes_voxels() const { return false; }
    /// Returns it as it is for the slices from z on; null: it changes nothing there. Called from one thread at a
    /// time, in order.
    virtual std::shared_ptr<const SliceEffect> at_slice(int32_t /*z*/) { return nullptr; }
    virtual std::vector<EffectChange> changes() const { return {}; }
};

}  // namespace openfab::process
