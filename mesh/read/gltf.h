// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads glTF 2.0, as text or .glb: the triangles of the default scene with the transforms of their
/// nodes, y up turned to z up, in metres. NORMAL is "n", TEXCOORD_0 "uv" (TEXCOORD_1 "uv1", …) with
/// v turned so that 0 is at the bottom, COLOR_0 "color" (3), and _NAME the attribute "name" in
/// lower case; all are floats. Nodes and materials are groups by their names. Points and lines,
/// skins and morph targets are left out with a warning; compressed meshes are refused. Errors name
/// the location in the JSON.
Result<MeshSource> parse_gltf(std::string_view bytes, const std::string& file,
                              int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh
