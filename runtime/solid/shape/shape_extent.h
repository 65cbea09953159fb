// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far a shape reaches along the axes of a turned space: what the box of its vertices is for a mesh.
// Nothing of it depends on the pitch of a print.

#include <array>
#include <vector>

#include "base/vec.h"
#include "runtime/solid/shape/shape_field.h"

namespace openfab::solid {

/// Searches the extent under a linear map whose rows are of length 1, by boxes that are halved: those
/// that bounds of the value decide are dropped, and points in the rest show what is reached for certain.
ShapeExtent find_extent(const ShapeField& field, const std::array<double, 9>& turn);

}  // namespace openfab::solid
