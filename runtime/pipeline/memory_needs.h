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

/// Computes the terms of placed parts. `fraction_channels` of the dither, `bits` of a
/// packed voxel, `pinned` from MemoryPlanner::max_pinned_bytes().
MemoryNeeds memory_needs(const std::vector<std::unique_ptr<volume::PlacedPart>>& parts,
                         const Vec3i& size, int32_t fraction_channels, int32_t bits, size_t pinned);

}  // namespace openfab::pipeline
