// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads back mesh files of a print for check_meshes.

#include <string>

#include "runtime/pipeline/slice_sink.h"
#include "tests/support/boundary/voxel_meshes.h"

namespace openfab::testing {

/// Converts a point of the print's build space to half voxels of its grid.
Vec3i half_voxels(const Vec3d& mm, const pipeline::PrintInfo& info);

/// Reads the meshes of a 3MF by material code, with shared vertices. Fails the test and returns
/// none if our reader rejects it.
CollectedMeshes read_threemf_meshes(const std::string& bytes, const pipeline::PrintInfo& info);

/// Reads the painted solid of a 3MF, likewise; materials by the colours that any reader sees.
PaintedMesh read_painted_threemf(const std::string& bytes, const pipeline::PrintInfo& info);

}  // namespace openfab::testing
