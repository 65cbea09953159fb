// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/result.h"
#include "tools/vrml/scene.h"

namespace openfab::tools {

/// Writes a scene as OBJ with its library, NAME.mtl beside it, and copies of its pictures from `folder`.
/// Shapes of one colour are of a material, others have colours of vertices. Corners that are equal are one
/// vertex of their shape.
Result<void> write_wavefront(const Scene& scene, const std::filesystem::path& folder,
                             const std::filesystem::path& obj);

}  // namespace openfab::tools
