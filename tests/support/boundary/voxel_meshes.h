// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Blocks of voxels, their meshes in memory, and checks of these: the mesher is compared with a
// twin, a list of all faces made one by one.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "backends/boundary/mesher.h"

namespace openfab::testing {

struct VoxelBlock {
    Vec3i size;
    std::vector<uint8_t> codes;  ///< x fastest, then y, z

    explicit VoxelBlock(Vec3i s)
        : size(s),
          codes(static_cast<size_t>(s.x) * static_cast<size_t>(s.y) * static_cast<size_t>(s.z)) {}
    uint8_t& at(Vec3i v) {
        return codes[(static_cast<size_t>(v.z) * static_cast<size_t>(size.y) +
                      static_cast<size_t>(v.y)) *
                         static_cast<size_t>(size.x) +
                     static_cast<size_t>(v.x)];
    }
    /// Returns the code of a voxel; void outside.
    uint8_t code(Vec3i v) const;
    int64_t count(uint8_t code) const;
};

struct CollectedMesh {
    std::vector<Vec3i> points;
    std::vector<std::array<uint32_t, 3>> triangles;
};

/// Meshes by code.
using CollectedMeshes = std::map<uint8_t, CollectedMesh>;

class Collector : public boundary::MeshReceiver {
  public:
    CollectedMeshes meshes;
    bool corners_fit = true;  ///< each corner of a triangle has its vertex's point

    Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) override;
    Result<void> take_triangles(uint8_t code,
                                std::span<const boundary::MeshTriangle> triangles) override;
    void check_corners();

  private:
    std::map<uint8_t, std::vector<boundary::MeshTriangle>> taken_;
};

/// Returns the meshes of a block from the mesher; an empty map where it failed.
CollectedMeshes mesh_block(const VoxelBlock& block);

/// Returns the meshes of a block with vertices identified by position, like in a file without
/// vertex indices: equal points are one. In steps, kSteps a voxel.
CollectedMeshes mesh_block_by_position(const VoxelBlock& block);

/// The meshes of all materials in one, with the material of each triangle.
struct PaintedMesh {
    CollectedMesh mesh;
    std::vector<uint8_t> codes;
};

/// Returns the meshes of a block whose vertices are numbered together; an empty one where the mesher failed.
PaintedMesh mesh_block_together(const VoxelBlock& block);

/// Checks the meshes of a block in one; returns the first fault: check_manifold; the volume is
/// not that of the voxels; a face of a material is not covered exactly once by it, from the right side.
std::string check_painted(const VoxelBlock& block, const PaintedMesh& painted);

/// Checks one mesh; returns the first fault, empty if none: degenerate triangles, edges that are
/// not between two triangles of opposite directions, vertices with no or several fans of triangles.
std::string check_manifold(const CollectedMesh& mesh);

/// Returns six times the volume in half voxels: 48 for each voxel.
int64_t six_volumes(const CollectedMesh& mesh);

/// Checks the meshes of a block; returns the first fault: check_manifold of each; the volume is not
/// that of the voxels; a face is not covered exactly once, from the right side; a triangle between
/// two materials is not in both meshes.
std::string check_meshes(const VoxelBlock& block, const CollectedMeshes& meshes);

/// Checks for self-intersections; returns the first: triangles that meet other than in vertices
/// that they share. Quadratic in the number of triangles.
std::string check_crossings(const CollectedMesh& mesh);

/// Checks that no side of a triangle of one mesh goes through one of another; returns the first.
std::string check_crossings(const CollectedMesh& one, const CollectedMesh& two);

enum class Crossings { kLookedFor, kNotLookedFor };

/// Checks the meshes of a block by position; returns the first fault: check_manifold and
/// check_crossings of each; the volume differs from the voxels' by more than a step all over the
/// surface; a face is not covered exactly once, from the right side and within a step.
std::string check_meshes_by_position(const VoxelBlock& block, const CollectedMeshes& meshes,
                                     Crossings crossings = Crossings::kLookedFor);

}  // namespace openfab::testing
