// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes as an output of a print: slices in, one boundary mesh a material out, in the space of the
// build, in millimetres.
//
// A mesh of some of the slices would be cut open where they end. So the files have their names only
// when the print is whole; one that fails or is interrupted leaves none, and those of an earlier
// print as they were.

#include <filesystem>
#include <memory>
#include <string>

#include "backends/boundary/mesher.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::boundary {

/// From half voxels to millimetres: the same place is the same number in every mesh.
class Coordinates {
  public:
    Coordinates() = default;
    explicit Coordinates(const backends::PrintInfo& info);
    Vec3f at(const Vec3i& point) const;
    /// Off the point as the corner says. A step that single precision does not tell is made one
    /// that it does.
    Vec3f at(const MeshCorner& corner) const;
    /// Whether single precision, which is what readers of meshes keep, tells half voxels apart; the
    /// error says at what pitch it would.
    static Result<void> check(const backends::PrintInfo& info);

  private:
    Vec3d origin_mm_, half_mm_;
};

/// A kind of files that meshes are written to.
class MeshWriter : public MeshReceiver {
  public:
    virtual Result<void> begin(const backends::PrintInfo& info) = 0;
    /// After the last triangle: the files are whole on the disk, or there is an error.
    virtual Result<void> end() = 0;
    // Without end nothing is left where a writer goes.
};

/// One binary STL a material: `-o out/part.stl` gives `out/part_white.stl` and so on, for those
/// materials that have voxels. Files of such names of an earlier print are replaced or removed. An
/// STL has no shared vertices, so readers find neighbours by places: sheets of a material that lie
/// on each other are parted (mesher.h), and each edge is between two triangles by places too.
std::unique_ptr<MeshWriter> make_stl_writer(const std::filesystem::path& path);

/// One 3MF package: an object a material, with its colour and name as a base material, and one
/// build item that has them all as components. While it is made, the meshes wait compressed in
/// files without a name beside it.
std::unique_ptr<MeshWriter> make_threemf_writer(const std::filesystem::path& path);

/// Where the mesh of a material goes: `stem_material.stl`, with what file names had better not have
/// replaced; material is its index in info.materials. No two are the same.
std::filesystem::path stl_path(const std::filesystem::path& path, const backends::PrintInfo& info,
                               size_t material);

class MeshSink : public backends::SliceSink {
  public:
    explicit MeshSink(std::unique_ptr<MeshWriter> writer) : writer_(std::move(writer)) {}

    Result<void> begin(const backends::PrintInfo& info) override;
    std::vector<uint8_t> encode(const backends::SliceView& slice) const override;
    Result<void> commit(int32_t z, const std::vector<uint8_t>& bytes) override;
    Result<void> finish(const backends::PrintTotals& totals) override;

  private:
    std::unique_ptr<MeshWriter> writer_;
    std::unique_ptr<Mesher> mesher_;
    backends::PrintInfo info_;
    bool broken_ = false;
};

}  // namespace openfab::boundary
