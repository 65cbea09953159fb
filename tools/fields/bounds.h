// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What bounds a level set: the box of a mesh, or the mesh, as a formula where it is convex.

#include <string>

#include "base/vec.h"
#include "mesh/read/threemf_model.h"

namespace openfab::tools {

struct FieldBounds {
    Box3d box;  ///< of the mesh, in its own coordinates
    std::string
        text;  ///< statements that end in `return`: a number that is below 0 inside, of a float3 `q`;
               ///< empty: it is not convex
};

FieldBounds bounds_of(const mesh::ThreemfObject& mesh, bool box_only);

/// The mesh as text of an OBJ file.
std::string obj_text(const mesh::ThreemfObject& mesh, const Affine3d& map);

}  // namespace openfab::tools
