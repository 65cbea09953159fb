// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads PLY: ASCII, little and big endian. Each further property is an attribute of its name.
/// Properties of vertices are floats; of faces, integers are ints and the others floats that are
/// the same at all corners. Consecutive properties that are components of a vector are one
/// attribute: nx ny nz as "n" (3), u v (s t, texture_u texture_v) as "uv" (2), red green blue as
/// "color" (3; 8-bit ones are sRGB from 0 to 255 and become linear from 0 to 1), and any NAME_x
/// NAME_y NAME_z, NAME_0 NAME_1 … as NAME. The list texcoord of faces is "uv". Other lists and
/// elements are skipped. Polygons are triangulated as in OBJ. Errors name the line in ASCII
/// files, else the element and its number from 0.
Result<MeshSource> parse_ply(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh
