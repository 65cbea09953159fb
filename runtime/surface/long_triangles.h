// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Long, thin triangles split before they are diced.
//
// A lattice has the factor of a triangle's longest edge along both of its axes. One of 300 x 3 mm
// would be diced a hundred times finer across than along, and its patches would be long, too: a
// query would hold hundreds of them. So a displaced triangle that is long is cut across, into
// pieces about as long as they are wide. Edges are cut by halving, which is decided by geometry
// alone, in double. Others that share an edge take over its middle, and halve their own longest
// edge first where that is another, so that the mesh stays closed and they do not become thin
// (Rivara 1984).

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "runtime/part/part.h"
#include "runtime/surface/surface.h"

namespace openfab::surface {

/// The triangle is longer than kMostSlender times its height, and is diced finer than this.
constexpr double kMostSlender = 4;
constexpr int32_t kLeastLongFactor = 64;

/// A copy of the mesh in which those triangles that are long, and that `displaced` names, are cut.
/// Values between corners are interpolated as dicing does. Null where nothing is to be done.
std::shared_ptr<const scene::PartMesh> split_long_triangles(const scene::PartMesh& mesh,
                                                            double micro_edge_mm,
                                                            std::vector<uint8_t> displaced);

/// The same of the triangles that the part's surface stage displaces: what its surface is to be
/// created with. The part's own mesh where nothing is to be done.
Result<std::shared_ptr<const scene::PartMesh>> mesh_to_dice(const scene::Part& part,
                                                            const SurfaceOptions& options);

}  // namespace openfab::surface
