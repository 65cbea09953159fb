// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A 3MF whose faces have the colours of mixtures, for machines that choose inks by the colours of a mesh.
//
// What is opaque is one closed mesh, what is clear (an alpha below one half) another, and support a third; their
// triangles have the colour of the voxel behind them. Void is what the slices have as void.

#include <memory>

#include "backends/boundary/mesh_sink.h"
#include "backends/boundary/mixture_colors.h"
#include "backends/common/mixture_inlet.h"

namespace openfab::boundary {

/// Memory for each voxel of a slice, in bytes, with so many slices in flight.
int64_t colored_bytes_per_column(int32_t slices);

class ColoredSink : public pipeline::SliceSink {
  public:
    ColoredSink(const std::filesystem::path& path, backends::MixtureInlet* inlet);

    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    MeshSink meshes_;
    ColorPlanes planes_;
    pipeline::PrintInfo info_;
    std::unique_ptr<MixtureColors> colors_;
    std::vector<Rgba> slice_;
};

}  // namespace openfab::boundary
