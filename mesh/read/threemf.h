// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "mesh/model/mesh_source.h"

namespace openfab::mesh {

/// Reads 3MF: the build's items with components and transforms, in the file's unit; of the
/// materials extension colour groups as "color" (3, linear), texture coordinates as "uv", and
/// multi-properties of these; of the production extension objects in other parts. Base materials
/// and objects are groups by their names. Supports and other objects that are not models are
/// left out with a warning. Errors name the part and its line.
Result<MeshSource> parse_threemf(std::string_view bytes, const std::string& file,
                                 int64_t memory_bytes = kDefaultReadingBytes);

/// Returns the name of the part that holds the model, from the text of the package's `_rels/.rels`.
Result<std::string> threemf_model_part(std::string_view relationships, const std::string& file);

}  // namespace openfab::mesh
