// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Splits long, thin triangles before they are diced.
//
// A lattice has the factor of a triangle's longest edge along both of its axes. One of 300 x 3 mm
// would be diced a hundred times finer across than along, and its patches would be long, too: a
// query would hold hundreds of them. So a displaced triangle that is long is cut across, into
// pieces about as long as they are wide. Edges are cut by halving, which is decided by geometry
// alone, in double. Neighbours at a split edge are split at its midpoint, too, after their own
// longest edge if that is another, so that the mesh stays closed and they do not become thin
// (Rivara 1984).

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

/// A triangle is long if it is longer than kMaxSlenderness times its height and its factor is above
/// kMinLongFactor.
constexpr double kMaxSlenderness = 4;
constexpr int32_t kMinLongFactor = 64;

/// Copies the mesh with its long triangles split, of those that `displaced` marks. Values between
/// corners are interpolated as in dicing. Returns null if there is nothing to split.
std::shared_ptr<const part::PartMesh> split_long_triangles(const part::PartMesh& mesh,
                                                           double micro_edge_mm,
                                                           std::vector<uint8_t> displaced);

/// Splits the long triangles that the part's surface stage displaces; the part's surface is created
/// from the result. Returns the part's own mesh if there is nothing to split.
Result<std::shared_ptr<const part::PartMesh>> mesh_to_dice(const part::Part& part,
                                                           const SurfaceOptions& options);

}  // namespace openfab::surface
