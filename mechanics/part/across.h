// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How many elements lie across walls, struts and necks: what a stress is resolved by.

#include <cstdint>
#include <span>
#include <vector>

#include "mechanics/model/voxels.h"

namespace openfab::mechanics {

/// Steps of an element in which thickness is kept, and the most that is told apart.
constexpr int kAcrossStep = 32, kAcrossMost = 4 * kAcrossStep;
/// Below two elements, and below four; a little less, for shares are means of a few samples.
constexpr int kUnresolved = 2 * kAcrossStep - 2, kCoarse = 4 * kAcrossStep - 2;

/// Of solid elements, in steps, at most kAcrossMost; 0 of others. The least of thirteen directions, by the
/// sum of shares, of what is not ten times softer, so that a stiff wall in a soft matrix is a wall; unless
/// `dithered`, where each voxel is alone. An edge of something thick is as thick as that: what a ball of
/// that thickness covers is.
std::vector<uint8_t> elements_across(const Grid& grid, const Voxels& voxels,
                                     std::span<const uint8_t> kind, bool dithered);

/// Gaps that end within elements: what lies on their two sides counts as joined.
struct BlurredGaps {
    int64_t elements = 0;
    size_t first = 0;  ///< one of them
};

/// Looks along the axes for one to three elements that are partly filled between two full ones.
BlurredGaps blurred_gaps(const Grid& grid, const Voxels& voxels);

/// How many times as stiff, and its stress as small, a part may be where its surface goes through elements: these have
/// their share of the material in their middle, so it lies too far out; and where elements are longer than they are
/// across: bent along that side, they are too stiff. 1 where neither is, or many lie across.
double cut_excess(const Grid& grid, const Voxels& voxels, std::span<const uint8_t> kind,
                  size_t element);

}  // namespace openfab::mechanics
