// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the faces of a PLY file look: pictures of `comment TextureFile`, as scanners and MeshLab write
// them, and colours of vertices or faces.

#include "mesh/model/mesh_source.h"
#include "mesh/read/ply_header.h"

namespace openfab::mesh {

/// Adds looks and the groups of faces by them. The mesh has its attributes: "uv", "color", and
/// "texnumber", the picture of a face where there are several.
void add_ply_looks(const PlyHeader& header, MeshSource* source);

}  // namespace openfab::mesh
