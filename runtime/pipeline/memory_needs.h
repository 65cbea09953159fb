// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts what the parts of a print take, for the planner of its memory.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/part/part.h"
#include "runtime/pipeline/memory_planner.h"
#include "runtime/volume/placed_part.h"

namespace openfab::pipeline {

/// Returns the bytes of the mapped textures of all parts, each counted once; they become resident
/// as the print reads them.
int64_t texture_bytes(const std::vector<part::Part>& parts);

/// Returns a lower bound, from counts, of the memory for setting up the surface of a part; 0 where
/// the fablet displaces nothing.
int64_t surface_bytes(const part::Part& part);
/// Returns the same for the bounding box, the index of patches and, if `asked`, the trees over a
/// surface that is set up.
int64_t tree_bytes(const surface::Surface& surface, bool asked);

/// Computes the terms of placed parts. `fraction_channels` of the dither, `bits` of a
/// packed voxel, `pinned` from MemoryPlanner::max_pinned_bytes().
MemoryNeeds memory_needs(const std::vector<std::unique_ptr<volume::PlacedPart>>& parts,
                         const Vec3i& size, int32_t fraction_channels, int32_t bits, size_t pinned);

}  // namespace openfab::pipeline
