// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Nearest points of a shape whose value is no distance: another engine finds them, on its
// micropolygons; distances are bounded without these.

#include <memory>

#include "runtime/nearest/engine.h"
#include "runtime/solid/shape/shape_near.h"
#include "runtime/solid/voxel_frame.h"

namespace openfab::solid {

/// `near` must outlive the engine.
std::unique_ptr<nearest::Engine> make_shape_engine(const ShapeNear& near, const VoxelFrame& frame,
                                                   std::unique_ptr<nearest::Engine> nearest);

}  // namespace openfab::solid
