// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where seams of pieces should be, as painted on a mesh.

#include <array>
#include <functional>
#include <string>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/mesh.h"

namespace openfab::tools {

/// Returns how much a seam is disliked at a point of part space, p -> stretch p, by an attribute of the
/// mesh: what the corners near it have of its first component.
Result<std::function<double(const Vec3d&)>> seam_of(const mesh::Mesh& mesh, const std::string& name,
                                                    const std::array<double, 9>& stretch);

}  // namespace openfab::tools
