// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh of a shape, for what moves its surface: @Surface is a function of a point on a mesh.

#include <memory>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/solid/kind.h"
#include "runtime/surface/surface.h"

namespace openfab::solid {

/// Makes a closed mesh of a part's shape, with normals and with the stage's outputs as the inputs that
/// the part's fablet has. Its cells have 1 to 8 times the print's pitch, by the size of the box: the
/// dicing of the displaced surface divides them.
Result<std::shared_ptr<const part::PartMesh>> mesh_of_shape(const part::Part& part,
                                                            const surface::SurfaceOptions& options,
                                                            const Bodies& bodies);

}  // namespace openfab::solid
