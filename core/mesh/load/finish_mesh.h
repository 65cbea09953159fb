// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The steps from the contents of a file to a mesh in millimetres, common to all formats.

#include <string>
#include <vector>

#include "base/result.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

struct Unit {
    double mm = 1;
    std::string note;  ///< where it comes from
};

/// The unit of a file, by all of it. A guess is a warning of the source.
Unit unit_of(MeshSource* source, const MeshOptions& options);

/// Finishes the mesh of a whole file or of one of its bodies; `looks` are the file's. Where
/// `tolerant` a mesh that cannot be printed has a refusal, instead of being an error.
Result<LoadedMesh> finish_mesh(MeshSource source, const std::vector<Look>& looks, const Unit& unit,
                               const MeshOptions& options, bool tolerant);

}  // namespace openfab::mesh
