// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The level sets that a 3MF file's build places, with all that their functions refer to.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "mesh/model/look.h"
#include "mesh/read/threemf_build.h"

namespace openfab::mesh {

struct ReadThreemfShapes {
    std::map<std::string, ThreemfModel> parts;
    const ThreemfModel* root = nullptr;  ///< the one with the build, among them
    std::vector<ThreemfPlaced> level_sets;
    bool has_meshes = false;  ///< the build places triangles, too
    /// Meshes that have volumetric data or are displaced.
    std::vector<ThreemfPlaced> meshes;
    std::vector<LeftOut> left_out;
};

/// Reads a file's functions and what uses them. Nothing is checked that a use of a function has to see.
/// Errors name the part and its line.
Result<ReadThreemfShapes> parse_threemf_shapes(std::string_view bytes, const std::string& file,
                                               int64_t memory_bytes);

}  // namespace openfab::mesh
