// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Types of glTF's properties. A property of another type would be taken as absent, and a colour or a
// body lost with it, so it is an error.

#include <string>

#include "base/json.h"
#include "base/result.h"

namespace openfab::mesh {

/// Returns an error at the first property, in order of the file, whose type is not that of the glTF 2.0 schema. Looks
/// into Khronos's extensions of materials and textures, but not into `extras` or other extensions, where names may mean
/// something else.
Result<void> check_gltf_types(const JsonValue& root, const std::string& file);

}  // namespace openfab::mesh
