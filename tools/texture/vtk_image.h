// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where VTK's image data lie, whichever of its files they are in.

#include <array>

#include "base/result.h"
#include "base/vec.h"
#include "tools/texture/placed_grid.h"

namespace openfab::tools {

/// The place of image data; of other structured grids the extent alone.
struct VtkImage {
    std::array<double, 6> extent{};  ///< of the piece: first and last point along each axis
    std::array<double, 3> origin{}, spacing{1, 1, 1};
    std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

/// Returns the number of texels along each axis, and sets where they lie; those of cells are their middles.
Result<Vec3i> image_size(const VtkImage& image, bool of_points, double unit, GridFrame* frame);

}  // namespace openfab::tools
