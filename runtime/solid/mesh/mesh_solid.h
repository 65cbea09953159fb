// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The geometry of a mesh, displaced by the surface stage of its fablet.

#include <memory>

#include "runtime/solid/kind.h"

namespace openfab::solid {

extern const Kind kMeshKind;

/// Makes the solid inside a surface of a part, which must outlive it. The surface is closed.
std::shared_ptr<Solid> make_solid_of(const part::Part& part,
                                     std::shared_ptr<const surface::Surface> surface);

}  // namespace openfab::solid
