// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Columns of numbers in a PLY file, as attributes of its mesh: `nx`, `ny`, `nz` are one vector, `red`,
// `green`, `blue` one colour.

#include <array>
#include <cstdint>
#include <vector>

#include "mesh/model/mesh_source.h"
#include "mesh/read/ply_header.h"

namespace openfab::mesh {

/// One scalar property of all vertices or faces.
struct PlyColumn {
    const PlyProperty* property = nullptr;
    std::vector<double> values;
    int64_t odd = -1;  ///< the first one that is not finite
};

/// Adds the columns of an element, "vertex" or "face", as attributes. `corners` selects the row of each
/// triangle corner.
void add_ply_attributes(const std::vector<PlyColumn>& columns, const char* element,
                        const std::vector<std::array<int32_t, 3>>& corners, MeshSource* out);

/// Lists transparent colours among what is left out: `alpha` behind colours is an attribute, but no look
/// has it.
void tell_ply_transparency(const std::vector<PlyColumn>& columns, MeshSource* out);

}  // namespace openfab::mesh
