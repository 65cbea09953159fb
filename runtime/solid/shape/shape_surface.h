// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The zero set of a shape as a surface of patches, for queries: a patch is a block of the lattice's
// cells, diced on demand.

#include <memory>
#include <vector>

#include "runtime/solid/shape/shape_field.h"
#include "runtime/surface/surface.h"

namespace openfab::solid {

/// Makes the surface of the field's blocks (ShapeField::find_blocks); both must outlive it.
std::unique_ptr<surface::Surface> make_shape_surface(const ShapeField& field,
                                                     const std::vector<Vec3i>& blocks,
                                                     size_t cache_bytes,
                                                     const std::atomic<bool>* stop);

}  // namespace openfab::solid
