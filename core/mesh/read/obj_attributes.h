// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the values of an OBJ text mean for its looks: colours of vertices, and where pictures are.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/model/mesh_source.h"
#include "mesh/read/mtl.h"

namespace openfab::mesh {

/// Adds the attribute `color` from the colours of vertices, sRGB as written, three each; those of
/// vertices without are not numbers. Faces of looks that have a colour somewhere, and not white
/// alone, are coloured by it. Sets Look::vertex_colors.
void add_obj_colors(std::vector<float> colors, const std::string& file, MeshSource* source);

/// Moves the values of `uv` as the materials of the looks say. A value that faces of several looks
/// share is copied; more than `most` copies are not made, and false is returned.
bool move_obj_pictures(const std::vector<const MtlMaterial*>& material_of_look, int64_t most,
                       MeshSource* source);

}  // namespace openfab::mesh
