// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads STL, binary or ASCII. Solids of ASCII files are bodies, and groups by their names. The two
/// bytes behind each binary triangle are the int attribute "attribute" where one is not 0; where
/// they are colours, as Magics and VisCAM write them, they are also the look, or "color" (3).
/// Normals are ignored: the order of corners decides, as the format requires. `file` stands for the
/// file in messages.
Result<MeshSource> parse_stl(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes = kDefaultReadingBytes);

}  // namespace openfab::mesh
