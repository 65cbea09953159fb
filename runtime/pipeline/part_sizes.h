// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Measures parts in voxels, to warn of parts that would vanish silently.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vec.h"
#include "runtime/part/part.h"
#include "runtime/solid/solid.h"
#include "runtime/volume/evaluate.h"

namespace openfab::pipeline {

/// Returns "`sheet` (number 0 of the build) is 80 x 80 x 0.4 voxels; …", the first few: of a mesh the
/// bounding box of its transformed box, so that rotated ones are over-estimated; of what has only a box
/// as its mesh, and of pieces, how far they reach. There is a solid for each part.
std::string part_sizes(std::span<const part::Part> parts,
                       const std::vector<std::shared_ptr<solid::Solid>>& solids,
                       const Vec3d& pitch_mm);

/// Returns a warning for each part that is thinner than a voxel along an axis, regardless of its
/// displacement, and so prints only where it happens to contain a voxel's centre; the first few,
/// and how many more there are.
std::vector<std::string> thin_part_warnings(
    std::span<const part::Part> parts, const std::vector<std::shared_ptr<solid::Solid>>& solids,
    const Vec3d& pitch_mm);

/// Returns one for each part of several that has no voxel, at most 4 and one for the rest. `covered`: by part,
/// whether it has any. Empty pieces are told where they are cut.
std::vector<std::string> lost_part_warnings(std::span<const part::Part> parts,
                                            const std::vector<bool>& covered);

/// Returns a note of the objects of which more than a hundredth gets no material, and one of those with negative amounts;
/// each names at most 4. Objects that are bound to void are left out: it is what they ask for. `voxels` are by part.
std::vector<std::string> empty_part_notes(std::span<const part::Part> parts,
                                          const std::vector<volume::PartVoxels>& voxels);

}  // namespace openfab::pipeline
