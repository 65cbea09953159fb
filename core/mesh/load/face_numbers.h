// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of faces, by which a fablet tells groups and looks apart, and the attributes that
// only some faces have.

#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mesh/load/load_mesh.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// What the numbers mean.
struct FaceNumbers {
    std::vector<std::pair<std::string, int32_t>> groups;  ///< name and number
    std::vector<int32_t> look_of;                         ///< by number, an index in looks, or -1
};

/// Gives a mesh the int attribute of its groups, by `options.groups`, else from 0 in the order of
/// their first faces: by the materials if any face has one, else by names, and by looks where there
/// are several. One number of faces without a name is no attribute.
Result<FaceNumbers> number_faces(MeshSource* source, const MeshOptions& options);

/// Faces whose look has a picture, but which lack coordinates, get that look without its picture.
void part_bare_faces(MeshSource* source);

/// Fills attributes that some faces lack, `uv` with 0 and `color` with white, where the looks say
/// which faces use them; leaves out others, with a warning, and those that no face has.
void complete_attributes(const std::vector<Look>& looks, MeshSource* source);

}  // namespace openfab::mesh
