// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Guesses whether a mesh is z-up, as prints are, or y-up, as figures mostly are.

#include <string>

#include "mesh/model/mesh.h"

namespace openfab::tools {

/// Returns the evidence for y-up, empty if none: the mesh is taller in y than in z, and has a flat
/// base at its lowest y and none at its lowest z; or stands on y = 0 with z = 0 inside its box.
/// Plates, boxes and flat objects have their base at the lowest z.
std::string y_up_evidence(const mesh::Mesh& mesh);

}  // namespace openfab::tools
