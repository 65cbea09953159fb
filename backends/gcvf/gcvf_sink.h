// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes a print as a GCVF, the file of GrabCAD Print's voxel printing. Experimental: made after what
// other writers of such files make; nobody has opened one of ours there yet.
//
// A ZIP without folders, all of it deflated:
//
// | file | holds |
// | --- | --- |
// | `slice_0.png`, `slice_1.png`, … | a slice each, RGBA, from 0 whatever --slices says |
// | `ConfigFile.xml` | resolution, size, and the materials: name, colour and number of voxels |
// | `Mesh.stl` | a coarse mesh (coarse_mesh.h), in millimetres |
// | `MeshBbx.ktn` | six `f32`, little-endian: the lowest and the highest corner of the printed voxels |
// | `Zbuffer.png` | the highest slice of each column (height_map.h) |
//
// The file appears when it is complete; a print that is interrupted leaves none, and an earlier one
// unchanged.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/common/package.h"
#include "backends/common/part_file.h"
#include "backends/gcvf/coarse_mesh.h"
#include "backends/gcvf/height_map.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::gcvf {

constexpr size_t kMostMaterials = 6;

/// Memory of a sink for each voxel of a slice, in bytes: the height map, and in 32 slices that wait
/// for their turn a bit; cells take a 64th of a mesher's.
constexpr int64_t kBytesPerColumn = 2 + 32 / 8 + 1;

/// Returns the text of `ConfigFile.xml`.
std::string config_xml(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                       bool flip_x);

class GcvfSink : public pipeline::SliceSink {
  public:
    /// `flip_x`: in pictures +x points left.
    GcvfSink(std::filesystem::path path, bool flip_x) : path_(std::move(path)), flip_x_(flip_x) {}

    /// Fails where the print has more materials or slices than a file can hold, or two materials of
    /// one colour.
    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    Result<void> add(int32_t z, std::span<const uint8_t> bytes);
    Result<void> write_rest(const pipeline::PrintTotals& totals);

    std::filesystem::path path_;
    bool flip_x_;
    pipeline::PrintInfo info_;
    size_t solid_bytes_ = 0;
    std::unique_ptr<backends::PartFile> file_;
    std::unique_ptr<backends::Package> package_;  ///< declared after file_, so destroyed before it
    std::optional<HeightMap> heights_;
    std::unique_ptr<CoarseMesh> mesh_;
    bool broken_ = false;
};

}  // namespace openfab::gcvf
