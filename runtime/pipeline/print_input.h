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
    std::string printer;
    std::string title;
    std::vector<std::string> warnings;  ///< copied to the statistics
    /// What of the machine's process decides voxels, as names and short texts, for the provenance.
    std::vector<std::pair<std::string, std::string>> process;
};

}  // namespace openfab::pipeline
