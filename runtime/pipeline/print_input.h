// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is printed: parts on a grid of some pitch, and their materials.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::pipeline {

struct PrintInput {
    std::vector<part::Part> parts;         ///< in build order
    std::vector<SliceMaterial> materials;  ///< code 1 is materials[0]
    /// The material code of support below parts; 0: no support.
    int32_t support_code = 0;
    Vec3d pitch_mm;
    /// How far material may run beyond the parts, but not below them: the grid covers that, too.
    Vec3i margin_vox;
    std::optional<Box3d> crop_mm;  ///< a box that the grid covers, too
    /// In place of the parts' own box: the grid is this one, rounded out to whole voxels, and what
    /// reaches beyond is cut off.
    std::optional<Box3d> window_mm;
    /// The grid begins at a whole number of these, instead of the pitch.
    std::optional<Vec3d> lattice_mm;
    /// Of each part whether it is printed; empty: all are. The grid is that of all, and fablets may ask
    /// those that are not.
    std::vector<uint8_t> only;
    /// So many parts, the last ones, do not count for the grid.
    int32_t beside_grid = 0;
    /// So many voxels more lie around the grid, on all sides.
    int32_t around_vox = 0;
    /// Above 0: all voxels in parts are of this material, whatever fablets make of them.
    uint8_t solid_code = 0;
    bool prints(size_t part) const { return only.empty() || only[part] != 0; }
    std::string printer;
    std::string title;
    std::vector<std::string> warnings;  ///< copied to the statistics
    /// What of the machine's process decides voxels, as names and short texts, for the provenance.
    std::vector<std::pair<std::string, std::string>> process;
};

}  // namespace openfab::pipeline
