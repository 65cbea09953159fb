// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fields on the cells of a mesh, as finite elements have them, sampled at the centres of texels by the
// cells' own shape functions.

#include <cstdint>
#include <optional>
#include <vector>

#include "texture/volume.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

/// Types of cells by VTK's numbers; the order of corners is VTK's, too.
enum class CellType : uint8_t { kTetrahedron = 10, kVoxel = 11, kHexahedron = 12, kWedge = 13 };

/// Returns how many corners cells of this type have; 0 for a type that is not sampled.
int corner_count(int type);

struct CellMesh {
    std::vector<double> points;    ///< three numbers each, mm
    std::vector<CellType> types;   ///< of each cell
    std::vector<int32_t> corners;  ///< points of all cells, one after the other
    int32_t channels = 1;
    bool of_points = true;      ///< else of cells
    std::vector<float> values;  ///< channels innermost

    /// Leaves only the values of these cells, in their order, which rises.
    void keep_values(const std::vector<int32_t>& cells);
    /// What its arrays take.
    int64_t bytes() const;
};

/// Puts `outside` in place of NaN, where it is given. Fails where a value is not finite.
Result<void> settle_field_values(std::optional<double> outside, std::vector<float>* values);
/// Returns the texels that cover the bounds of so many cells, at `pitch_mm` of the options, or a third of a
/// cell's side, as it is on average where cells fill their bounds.
Result<ResampledBox> cell_box(const Box3d& bounds, double cells,
                              const texture::VolumeOptions& options);

/// Samples the field on cell_box. Tetrahedra are linear, hexahedra trilinear, wedges linear times
/// linear; where cells share a face or overlap, the first counts. A texel whose centre lies less than
/// two texels outside has the value to which the nearest cell continues, within the bounds of all
/// values, so that points just under the surface are right; all others have `outside`, else 0. Cells
/// without volume cover nothing. Points that cells name exist.
MadeReader open_cell_field(CellMesh mesh, const texture::VolumeOptions& options,
                           const texture::ReadLimits& limits);

}  // namespace openfab::tools
