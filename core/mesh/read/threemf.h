// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads 3MF: the build's items with components and transforms, in the file's unit; of the
/// materials extension base materials and their composites, colours, pictures, and multi-properties
/// of these as looks, with colours as "color" (3, linear) and texture coordinates as "uv"; of the
/// production extension objects in other parts, whose resources are their own; boolean shapes as
/// negative bodies. Each placed object with a mesh is a body. Supports and other objects that are
/// not models are left out. Errors name the part and its line.
Result<MeshSource> parse_threemf(std::string_view bytes, const std::string& file,
                                 int64_t memory_bytes = kDefaultReadingBytes);

/// Hands over the pictures of a 3MF file that looks name as their sources: each one's bytes or why
/// there are none, in their order.
Result<void> read_threemf_pictures(const std::filesystem::path& file,
                                   std::span<const std::string> sources, int64_t memory_bytes,
                                   const TakePicture& take);

}  // namespace openfab::mesh
