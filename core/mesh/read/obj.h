// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefront OBJ. Not from a library: those read malformed numbers as 0 and report no lines, and a
// subtly wrong print costs a day.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads positions, `vt` as "uv" (2), `vn` as "n" (3), `g` and `usemtl` as groups. Each `o`, and
/// each set of groups in it, is a body. Each material that faces use is a look, as the libraries of
/// `mtllib` beside `file` have it. Colours of vertices, sRGB from 0 to 1 or 255, are "color" (3) in
/// linear light; they go before a material's colour, and below its picture. Polygons are triangulated: convex ones as a fan from their first corner,
/// others by ear clipping. A comment `# Units: cm`, as modelling programs write it, is the unit.
/// `file` stands for the file in messages; errors are `file:line:column`.
Result<MeshSource> parse_obj(std::string_view text, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

/// Reads pictures of the looks of an OBJ file, files in its folder or below.
Result<void> read_obj_pictures(const std::filesystem::path& file,
                               std::span<const std::string> sources, int64_t memory_bytes,
                               const TakePicture& take);

}  // namespace openfab::mesh
