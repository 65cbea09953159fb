// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads OFF of Geomview as text, with the prefixes that say what a vertex has: N a normal, C a colour, ST
/// texture coordinates ("uv"). Colours of vertices and of faces, sRGB as integers to 255 or fractions to 1,
/// are "color" (3) in linear light; those of faces go first. Polygons are triangulated as in OBJ, faces of
/// two corners told. Errors name the line.
Result<MeshSource> parse_off(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh
