// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// From slices to shards.

#include <cstdint>
#include <span>
#include <vector>

#include "backends/zarr/layout.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::zarr {

/// Cuts a slice into tiles, those of a chunk: a byte for each, row by row, its code where it has only one, else 255;
/// then the packed rows of the others. So a slice that waits for its slab takes no more than its packed rows, and
/// what is of one material is found once.
std::vector<uint8_t> split_tiles(const pipeline::SliceView& slice, int32_t bits);

/// Makes a shard of planes of codes, one a byte, as many as the level's depth or fewer. Empty for void.
Result<std::vector<uint8_t>> make_shard(const Level& level, std::span<const uint8_t> planes);

/// Makes the shards of a slab, one for each level that it has, from what split_tiles made of its slices.
Result<std::vector<std::vector<uint8_t>>> make_shards(std::span<const std::vector<uint8_t>> slices,
                                                      std::span<const Level> levels, int32_t bits);

/// Halves planes of `finer`; their number is halved, rounded up.
std::vector<uint8_t> halve_planes(const Level& finer, std::span<const uint8_t> planes);

}  // namespace openfab::zarr
