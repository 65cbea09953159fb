// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Grids whose cells follow from the numbers of points along three indices: curvilinear ones of VTK and
// XDMF. They are sampled as the hexahedra that they are.

#include <array>

#include "tools/texture/cell_field.h"

namespace openfab::tools {

/// Counts the points of such a grid. Fails where a side has no cell, and where there are too many.
Result<int64_t> structured_points(const std::array<int64_t, 3>& points_along);

/// Returns the mesh of such a grid, without points and values: a hexahedron between each eight neighbours,
/// x fastest, then y, z. Fails where a side has no cell, or where points, cells and the values of
/// `channels` take more than the limits have.
Result<CellMesh> structured_cells(const std::array<int64_t, 3>& points_along, int32_t channels,
                                  bool of_points, const texture::ReadLimits& limits);

}  // namespace openfab::tools
