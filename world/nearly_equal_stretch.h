// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "world/world.h"

namespace openfab::world {

/// Transforms that other programs write have six decimals, mostly, so a rotation is none exactly, and
/// each placement would be a shape of its own. The stretch S of M = R S (base/polar.h) becomes the
/// identity where no entry differs from it by more than 1e-6; else that of an earlier placement of the
/// mesh, where none differs from that by more than 1e-6 of the largest. Returns the number of placements
/// that were changed.
size_t equalise_stretches(World* world);

}  // namespace openfab::world
