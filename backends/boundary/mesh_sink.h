// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Meshes as an output of a print: one boundary mesh per material, in build space, in millimetres.
//
// A mesh of only some slices would be cut open where they end. So files get their names only when
// the print is complete; one that fails or is interrupted leaves none, and those of an earlier
// print unchanged.

#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "backends/boundary/mesher.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::boundary {

/// Converts half voxels to millimetres: equal points become equal numbers in all meshes.
class Coordinates {
  public:
    Coordinates() = default;
    explicit Coordinates(const pipeline::PrintInfo& info);
    Vec3f at(const Vec3i& point) const;
    /// Returns the corner's point plus its offset. A step below single precision is enlarged to the
    /// smallest one that changes the number.
    Vec3f at(const MeshCorner& corner) const;
    /// Fails where single precision, which readers of meshes use, cannot distinguish half voxels;
    /// the error names a pitch at which it can.
    static Result<void> check(const pipeline::PrintInfo& info);

  private:
    Vec3d origin_mm_, half_mm_;
};

/// A file format of meshes.
class MeshWriter : public MeshReceiver {
  public:
    virtual Result<void> begin(const pipeline::PrintInfo& info) = 0;
    /// Finishes after the last triangle: the files are completely on the disk, or an error.
    virtual Result<void> end(const pipeline::PrintTotals& totals) = 0;
    // A writer that is destroyed without `end` leaves no files.
};

/// Writes one binary STL per material: `-o out/part.stl` gives `out/part_white.stl` and so on, for
/// those materials that have voxels. Files of such names of an earlier print are replaced or
/// removed. Their headers have a digest, the print that they are of, and which slices of it. An STL has no shared vertices, so readers find neighbours by position: coincident
/// sheets of a material are separated (mesher.h), so that each edge is between two triangles by
/// position, too.
std::unique_ptr<MeshWriter> make_stl_writer(const std::filesystem::path& path);

/// Writes one 3MF package: an object per material, with its colour and name as a base material, and
/// one build item that has them all as components and puts the lowest slice on the bed; the filament
/// of each object, from 1, as OrcaSlicer and Bambu Studio read it. Meanwhile the meshes are compressed in unnamed
/// files beside it.
std::unique_ptr<MeshWriter> make_threemf_writer(const std::filesystem::path& path);

/// Same, with coincident sheets of a material separated as in an STL, for programs that join vertices at equal positions.
std::unique_ptr<MeshWriter> make_apart_writer(const std::filesystem::path& path);

/// Writes one 3MF package: an object for each material, whose triangles have colours of a colour group of the Materials
/// Extension.
std::unique_ptr<MeshWriter> make_colored_writer(const std::filesystem::path& path);

/// The most filaments that slicers number in painted triangles.
/// Source: PrusaSlicer 2.5, EnforcerBlockerType in libslic3r/TriangleSelector.hpp.
constexpr size_t kMostFilaments = 15;

/// Writes one 3MF package for printers of filament: the closed meshes of all materials in one object, which
/// PrusaSlicer reads as volumes of it; the first of info.materials is filament 1 and so on. Each triangle has
/// its colour for any reader, and its filament as OrcaSlicer and Bambu Studio store painting. Fails for more
/// than kMostFilaments materials.
std::unique_ptr<MeshWriter> make_filament_writer(const std::filesystem::path& path);

class FilamentMixtures;

/// Same for filaments and their mixtures, which are known when the mesh ends: info.materials are kMostFilaments, of which those
/// that `mixtures` has then are used.
std::unique_ptr<MeshWriter> make_mixed_writer(const std::filesystem::path& path,
                                              const FilamentMixtures* mixtures);

/// Returns the file of a material's mesh: `stem_material.stl`, with unsafe characters replaced;
/// `material` is its index in info.materials. All are different.
std::filesystem::path stl_path(const std::filesystem::path& path, const pipeline::PrintInfo& info,
                               size_t material);

class MeshSink : public pipeline::SliceSink {
  public:
    explicit MeshSink(std::unique_ptr<MeshWriter> writer) : writer_(std::move(writer)) {}

    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    /// Same with the colours of the slice's voxels, for a writer that has colours.
    Result<void> commit_colored(int32_t z, std::vector<uint8_t> bytes,
                                std::span<const uint32_t> colors);
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    std::unique_ptr<MeshWriter> writer_;
    std::unique_ptr<Mesher> mesher_;
    pipeline::PrintInfo info_;
    bool broken_ = false;
};

}  // namespace openfab::boundary
