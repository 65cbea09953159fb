// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts measured in voxels, for what would otherwise vanish without a word.

#include <string>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/print.h"

namespace openfab::print {

/// "`sheet` (number 0 of the build) is 80 x 80 x 0.4 voxels; …", the first few: the box of each
/// mesh as it is placed, as the box of that box, so that what is turned counts as more rather than
/// less.
std::string part_sizes(const std::vector<scene::Part>& parts, const Vec3d& pitch_mm);

/// A warning for each part that is thinner than a voxel along an axis, whatever its displacement
/// does, and so prints only where it happens to hold a voxel's centre; the first few, and how many
/// more there are.
std::vector<std::string> thin_part_warnings(const std::vector<scene::Part>& parts,
                                            const Vec3d& pitch_mm);

/// The warning for a whole print without a voxel of material; empty where it has one. `sizes` is
/// that of part_sizes.
std::string nothing_printed(const slab::PrintStatistics& statistics, const std::string& sizes);

}  // namespace openfab::print
