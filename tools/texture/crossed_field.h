// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fields on rectilinear grids, of VTK and XDMF: places along x, y and z that are crossed. Three look-ups
// find the cell of a texel, for a whole axis at once.

#include <array>
#include <cstdint>
#include <vector>

#include "texture/volume.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

struct CrossedField {
    std::array<std::vector<double>, 3> axes;  ///< places of points, mm, which rise or fall
    int32_t channels = 1;
    bool of_points = true;      ///< else of the cells between them
    std::vector<float> values;  ///< channels innermost, then x, y, z
};

/// Counts the values of such a field without its channels. Fails where a side has no cell, or where the
/// values take more than the limits have.
Result<int64_t> crossed_items(const std::array<int64_t, 3>& points_along, int32_t channels,
                              bool of_points, const texture::ReadLimits& limits);

/// Samples the field as open_cell_field (cell_field.h) samples the grid's cells, which are cuboids. Fails
/// where the places along an axis go to and fro.
MadeReader open_crossed_field(CrossedField field, const texture::VolumeOptions& options);

}  // namespace openfab::tools
