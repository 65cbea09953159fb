// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A coarse mesh of a print, to place and look at it by: the boundary of the cubes of 8 x 8 x 8 voxels
// that hold any material, cut off at the grid's upper faces. It contains the print, and is less than
// 8 voxels larger.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backends/boundary/mesher.h"
#include "backends/common/deflate_spool.h"
#include "backends/common/package.h"

namespace openfab::gcvf {

class CoarseMesh : public boundary::MeshReceiver {
  public:
    /// Triangles wait, compressed, in an unnamed file in `folder`.
    static Result<std::unique_ptr<CoarseMesh>> create(const pipeline::PrintInfo& info,
                                                      const std::filesystem::path& folder);

    /// Adds the next slice, as solid bits.
    Result<void> add(std::span<const uint8_t> solid);
    /// Writes the mesh to the package as a binary STL in millimetres of build space.
    Result<void> finish(backends::Package* package, const std::string& name);

    bool identifies_by_position() const override { return true; }
    Result<void> take_vertices(uint8_t, std::span<const Vec3i>) override { return {}; }
    Result<void> take_triangles(uint8_t code,
                                std::span<const boundary::MeshTriangle> triangles) override;

  private:
    CoarseMesh(const pipeline::PrintInfo& info, Vec3i size,
               std::unique_ptr<backends::DeflateSpool> spool);
    Result<void> add_cells();
    Vec3f at(const boundary::MeshCorner& corner) const;

    Vec3i voxels_;  ///< of the print; z counts the slices that are printed
    Vec3d origin_mm_, pitch_mm_;
    int32_t width_, height_;      ///< of a slice of cells
    std::vector<uint8_t> cells_;  ///< of the eight slices that are being added: 1 where solid
    int32_t slices_ = 0;
    int64_t triangles_ = 0;
    std::unique_ptr<backends::DeflateSpool> spool_;
    std::vector<uint8_t> facets_;
    boundary::Mesher mesher_;
};

}  // namespace openfab::gcvf
