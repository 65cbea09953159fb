// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Distances of a shape whose value is declared to be one: the value itself. Nearest points, where
// something reads attributes of them, come from another engine.

#include <memory>

#include "runtime/nearest/engine.h"
#include "runtime/solid/shape/shape_field.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

/// `nearest`: finds nearest points; null where nothing reads them. The field must outlive the engine.
std::unique_ptr<nearest::Engine> make_value_engine(const ShapeField& field, const VoxelFrame& frame,
                                                   std::unique_ptr<nearest::Engine> nearest);

}  // namespace openfab::solid
