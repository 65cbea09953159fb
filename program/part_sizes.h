// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measures parts in voxels, to warn of parts that would vanish silently.

#include <string>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/pipeline/print_job.h"

namespace openfab::program {

/// Returns "`sheet` (number 0 of the build) is 80 x 80 x 0.4 voxels; …", the first few: the
/// bounding box of each mesh's transformed box, so that rotated parts are over-estimated.
std::string part_sizes(const std::vector<part::Part>& parts, const Vec3d& pitch_mm);

/// Returns a warning for each part that is thinner than a voxel along an axis, regardless of its
/// displacement, and so prints only where it happens to contain a voxel's centre; the first few,
/// and how many more there are.
std::vector<std::string> thin_part_warnings(const std::vector<part::Part>& parts,
                                            const Vec3d& pitch_mm);

/// Returns the warning for a print without any voxel of material; empty where it has one. `sizes`
/// is from part_sizes.
std::string nothing_printed(const pipeline::PrintStatistics& statistics, const std::string& sizes);

}  // namespace openfab::program
