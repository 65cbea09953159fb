// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether a mesh stands on its lowest z, as prints do, or was made with y up, as figures mostly
// are.

#include <string>

#include "mesh/model/mesh.h"

namespace openfab::tool {

/// What speaks for y: it is taller in y than in z, and stands there: on a flat base at its lowest y
/// and none such at its lowest z; or on y = 0, with z = 0 amid it. Plates, boxes and what lies flat
/// have their base at the lowest z. Empty where nothing speaks for it.
std::string why_y_seems_up(const scene::Mesh& mesh);

}  // namespace openfab::tool
