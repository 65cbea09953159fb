// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads PLY: ASCII, little and big endian. Each further property is an attribute of its name.
/// Properties of vertices are floats; of faces, integers are ints and the others floats that are
/// the same at all corners. Consecutive properties that are components of a vector are one
/// attribute: nx ny nz as "n" (3), u v (s t, texture_u texture_v) as "uv" (2), red green blue as
/// "color" (3; sRGB from 0 to 255, 65535, or 1 if they are floats, which becomes linear light from 0
/// to 1), and any NAME_x NAME_y NAME_z, NAME_0 NAME_1 … as NAME. The list texcoord of faces is
/// "uv". A `comment TextureFile NAME` is the picture of faces with "uv", of several the one of their
/// `texnumber`. Other elements are left out. Polygons are triangulated as in OBJ. Errors name the line in ASCII
/// files, else the element and its number from 0.
Result<MeshSource> parse_ply(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

/// Reads pictures of the looks of a PLY file, files in its folder or below.
Result<void> read_ply_pictures(const std::filesystem::path& file,
                               std::span<const std::string> sources, int64_t memory_bytes,
                               const TakePicture& take);

}  // namespace openfab::mesh
