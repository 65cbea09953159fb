// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nozzles that give no drops. In the voxels of their rows the fraction of their material goes to a
// substitute, before the dither: so a dither spreads what it diffuses over what can be printed, and
// rule 20 stands as it is. A row of voxels belongs to one nozzle of one pass in each layer.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/dither/band.h"
#include "runtime/process/effect.h"

namespace openfab::process {

/// Which rows of the tray have no drop of a material: shifted row r = row + jog * layer is of pass r mod
/// passes and of nozzle (r div passes) mod head.
struct DeadRows {
    uint8_t material = 0, substitute = 0;  ///< codes
    std::vector<Vec2<int32_t>> nozzles;    ///< ranges, both ends included
    int32_t head = 0;                      ///< 0: rows of a pass are counted from the tray's edge
    int32_t passes = 1;
    int32_t pass = -1;  ///< -1: all
    int32_t jog = 0;

    bool holds(int64_t row, int64_t layer) const;
};

/// How voxels of a grid lie in rows and layers of the machine, whose pitch may be another. A voxel of a
/// draft lies in several and counts as one of them, another than its neighbours: of any box of voxels
/// each row of the machine gets its share, nearly.
struct MachineRows {
    double first_row = 0, rows_a_voxel = 1;      ///< along y, of the grid's lowest voxel row
    double first_layer = 0, layers_a_voxel = 1;  ///< along z

    static MachineRows of(const Vec3d& origin_mm, const Vec3d& pitch_mm, const Vec3d& own_pitch_mm);
    /// Return the first and last row, or layer, of the machine that voxels may count as.
    Vec2<int64_t> rows(int32_t y) const;
    Vec2<int64_t> layers(int32_t z) const;
    /// Return which of them a voxel does count as.
    int64_t row(const Vec3i& voxel) const;
    int64_t layer(const Vec3i& voxel) const;
};

class Nozzles : public SliceEffect {
  public:
    /// By code: the one that is printed in its place, itself where it can be printed.
    using CodeMap = std::array<uint8_t, 256>;

    Nozzles(std::vector<DeadRows> dead, const MachineRows& rows);

    bool empty() const { return dead_.empty(); }
    /// Sets the map of the voxels that count as of a row and a layer of the machine; returns whether any
    /// code is replaced. A material whose substitutes are all dead keeps its code, which check refuses.
    bool map(int64_t row, int64_t layer, CodeMap* map) const;
    /// Fails where a material of the grid has a row without any live substitute.
    Result<void> check(const Vec3i& size, const std::vector<std::string>& names) const;

    /// Substitutes in mixtures, too.
    void before_dither(int32_t slab, int32_t height, dither::RowBand* band) const override;
    void after_dither(int32_t slab, int32_t height, dither::RowBand* band) const override;

  private:
    class RowMaps;

    void apply_to_row(int32_t y, RowMaps* maps, dither::RowBand* band) const;

    std::vector<DeadRows> dead_;
    MachineRows rows_;
    bool jogs_;  ///< layers matter
};

}  // namespace openfab::process
