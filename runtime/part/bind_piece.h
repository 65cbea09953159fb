// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Brings the piece that a placement prints to part space, and checks that its connectors fit there.

#include <memory>

#include "base/polar.h"
#include "base/result.h"
#include "runtime/part/part.h"
#include "world/world.h"

namespace openfab::part {

/// `part` has its mesh and fablet. Errors have the location of the connector, or of the placement.
Result<std::shared_ptr<const Piece>> bind_piece(const world::World& world,
                                                const world::Placement& placement,
                                                const PolarFactors& polar, const Part& part);

}  // namespace openfab::part
