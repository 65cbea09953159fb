// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Sparse grids of voxels, and the OpenVDB file that holds them. The only code that knows OpenVDB.

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/vec.h"

namespace openfab::tools {

/// Where voxels lie: (0, 0, 0) has its lowest corner at `origin_mm`.
struct VoxelFrame {
    Vec3d origin_mm, pitch_mm;
};

/// 8 x 8 x 8 values, z fastest, then y, then x, as OpenVDB has them.
template <typename T>
using VoxelBlock = std::array<T, 512>;

/// Returns the place of a voxel in a block; its coordinates are 0 to 7.
inline size_t place_in_block(int32_t x, int32_t y, int32_t z) {
    return static_cast<size_t>(x << 6 | y << 3 | z);
}

/// Grids whose background is 0; what is not 0 is active. A grid's index space has voxel (x, y, z) at
/// these whole numbers, and its transform leads to the voxel's center in millimetres.
class SparseGrids {
  public:
    /// More than `memory_bytes` of voxels are refused.
    SparseGrids(const VoxelFrame& frame, int64_t memory_bytes);
    ~SparseGrids();
    SparseGrids(const SparseGrids&) = delete;
    SparseGrids& operator=(const SparseGrids&) = delete;

    /// Add a grid and return its index.
    size_t add_codes(const std::string& name);
    size_t add_amounts(const std::string& name);
    /// Adds a text to a grid's metadata.
    void note(size_t grid, const std::string& key, const std::string& text);

    /// Set the block whose lowest voxel is `corner`, of which all coordinates are multiples of 8. Each
    /// block at most once.
    Result<void> set(size_t grid, const Vec3i& corner, const VoxelBlock<int32_t>& codes);
    Result<void> set(size_t grid, const Vec3i& corner, const VoxelBlock<float>& amounts);

    /// Writes the file, which appears when it is complete. Its bytes are different each time: OpenVDB
    /// puts a random number in.
    Result<void> write(const std::filesystem::path& path) const;

  private:
    struct Grids;
    template <typename Grid, typename T>
    Result<void> set_block(Grid& grid, const Vec3i& corner, const VoxelBlock<T>& values);

    std::unique_ptr<Grids> grids_;
    int64_t memory_bytes_;
};

}  // namespace openfab::tools
