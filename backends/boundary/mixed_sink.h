// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A 3MF for printers of filament whose mixtures a slicer prints: each mixture is a filament of its own (filament_mixtures.h).

#include "backends/boundary/filament_mixtures.h"
#include "backends/boundary/mesh_sink.h"
#include "backends/common/mixture_inlet.h"

namespace openfab::boundary {

/// Memory for each voxel of a slice, in bytes, with so many slices in flight.
int64_t mixed_bytes_per_column(int32_t slices);

class MixedSink : public pipeline::SliceSink {
  public:
    MixedSink(const std::filesystem::path& path, backends::MixtureInlet* inlet);

    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    class Planes : public MixturePlanes<Quarters> {
        Quarters value_of(std::span<const float> fractions) const override {
            return quarters_of(fractions);
        }
    };

    FilamentMixtures mixtures_;  ///< outlives the writer that reads it
    MeshSink meshes_;
    Planes planes_;
    pipeline::PrintInfo info_;
    bool broken_ = false;
};

}  // namespace openfab::boundary
