// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Converts a mesh to the part-local mesh that the pipeline runs on, with its attributes laid out
// for a fablet.

#include <array>
#include <memory>

#include "base/polar.h"
#include "base/result.h"
#include "mesh/model/mesh.h"
#include "runtime/part/part.h"

namespace openfab::part {

/// Applies S to the mesh, moves it to the centre of its box, and resolves the surface inputs and
/// @nearest attributes of `fablet`. Normals are those of the mesh (attribute "n") transformed by
/// the inverse of S, else the flat geometric ones. Fails where the mesh lacks an attribute that has
/// no default, or has it with another type; the message names the mesh and lists what it has.
Result<std::shared_ptr<const PartMesh>> make_part_mesh(const mesh::Mesh& mesh,
                                                       const openfab_fablet& fablet,
                                                       const std::array<double, 9>& s);

/// Returns whether a fablet neither moves the surface nor reads attributes of it: for all such fablets
/// make_part_mesh gives the same.
bool is_plain(const openfab_fablet& fablet);

/// Returns an upper bound of the bytes that make_part_mesh allocates.
int64_t part_mesh_bytes(const mesh::Mesh& mesh, const openfab_fablet& fablet);

/// Returns local_to_build: R and the translation that together map part-local points as M and t do.
Affine3d part_local_to_build(const PolarFactors& polar, const Vec3d& translation_mm,
                             const Vec3d& center_part_mm);

}  // namespace openfab::part
