// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/print_options.h"
#include "runtime/solid/solid.h"

namespace openfab::pipeline {

/// Makes the grid of a print: the exact box of all displaced parts, rounded out to whole voxels.
/// Its origin is a whole number of pitches from build (0, 0, 0), so voxel centres do not move when
/// a part is added to the print. Positions are rounded to 1/256 voxel first, as the voxeliser does,
/// so that a box whose side is a whole number of pitches gets no empty layer from the last bit of a
/// double. `margin_vox` lies around them, but not below. `crop_mm` is covered too; with `window_mm` that
/// box alone is. With `lattice_mm` the origin is a whole number of these instead, next to the box, so that
/// voxels which are larger begin where the parts do. Fails for grids that no print can hold.
Result<part::Grid> make_grid(std::span<const part::Part> parts,
                             const std::vector<std::shared_ptr<solid::Solid>>& solids,
                             const Vec3d& pitch_mm, int32_t bits, const Vec3i& margin_vox = {},
                             const std::optional<Box3d>& crop_mm = {},
                             const std::optional<Box3d>& window_mm = {},
                             const std::optional<Vec3d>& lattice_mm = {});

/// Returns the first slice and one past the last that `options` select.
Result<Vec2<int32_t>> slice_range(const part::Grid& grid, const PrintOptions& options);

}  // namespace openfab::pipeline
