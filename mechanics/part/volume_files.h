// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Results as volumes: VTK's image data, and arrays of numpy.

#include <filesystem>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

/// FILE.vti: displacement_mm at nodes; von_mises_MPa, tension_MPa, compression_MPa, safety, solid and
/// material (0 void, else by its place in the list of materials) of elements; `weakness` unless it is empty.
Result<void> write_vti(const std::filesystem::path& file, const PartProblem& problem,
                       const PartFields& fields, const Field<double, kElastic>& moved_mm,
                       const std::vector<float>& weakness = {});

/// FILE.npy: float32 of shape (z, y, x, 8), of each element: the mean displacement of its corners in mm,
/// then the others of the above up to `solid`. FILE.npy.json beside it has their names, pitch, origin and
/// materials.
Result<void> write_npy(const std::filesystem::path& file, const PartProblem& problem,
                       const PartFields& fields, const Field<double, kElastic>& moved_mm);

}  // namespace openfab::mechanics
