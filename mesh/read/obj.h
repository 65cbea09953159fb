// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Wavefront OBJ. Not from a library: those read malformed numbers as 0 and report no lines, and a
// subtly wrong print costs a day.

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads positions, `vt` as "uv" (2), `vn` as "n" (3), vertex colours as "color" (3), `g` and
/// `usemtl` as groups. Polygons are triangulated: convex ones as a fan from their first corner,
/// others by ear clipping. A comment `# Units: cm`, as modelling programs write it, is the unit.
/// `file` stands for the file in messages; errors are `file:line:column`.
Result<MeshSource> parse_obj(std::string_view text, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh
