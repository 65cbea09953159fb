// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes that a print has written to files, read back for check_meshes.

#include <string>

#include "runtime/pipeline/slice_sink.h"
#include "tests/support/boundary/voxel_meshes.h"

namespace openfab::testing {

/// The place of a point of the print's build space, in half voxels of its grid.
Vec3i half_voxels(const Vec3d& mm, const backends::PrintInfo& info);

/// The meshes of a 3MF by the codes of their materials, with the vertices that it shares. None, and
/// a failed test, where our reader refuses it.
CollectedMeshes read_threemf_meshes(const std::string& bytes, const backends::PrintInfo& info);

}  // namespace openfab::testing
