// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Results as volumes: VTK's image data, and arrays of numpy.

#include <filesystem>
#include <functional>

#include "mechanics/part/part_results.h"

namespace openfab::mechanics {

/// What a FILE.vti holds: one array at nodes, and arrays of elements.
struct VolumeArrays {
    const char* at_nodes = "";
    int components = 1;
    /// A row of nodes of a component, at y and z.
    std::function<const double*(int, int32_t, int32_t)> row;
    std::vector<std::pair<const char*, const std::vector<float>*>> floats;
    const std::vector<uint8_t>* material = nullptr;
};
Result<void> write_vti(const std::filesystem::path& file, const Grid& grid, const Vec3& origin_mm,
                       const VolumeArrays& arrays);

/// FILE.npy of float32, (z, y, x, names), a row of elements at a time; FILE.npy.json beside it has the names,
/// pitch, origin and materials.
Result<void> write_npy(const std::filesystem::path& file, const Grid& grid, const Vec3& origin_mm,
                       const std::vector<std::string>& materials,
                       std::span<const char* const> names,
                       const std::function<void(int32_t y, int32_t z, float* row)>& fill);

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
