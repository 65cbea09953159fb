// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The solid of what has no mesh, as a mesh of voxels: the print program of the world makes it.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "tools/openfab/extents.h"

namespace openfab::tools {

struct SolidMesh {
    std::vector<Vec3d> positions;  ///< in the build, mm
    std::vector<std::array<int32_t, 3>> triangles;
    double pitch_mm = 0;  ///< of the voxels
};

/// Makes the mesh of an object within a box of the build, in which one placement of it stands. `options`: as of
/// find_extents.
Result<SolidMesh> solid_mesh(const std::string& world, const WorldOptions& options,
                             const std::string& object, const Box3d& within, int64_t memory_bytes);

}  // namespace openfab::tools
