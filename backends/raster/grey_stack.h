// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes a folder of grey pictures from fractions, slice by slice.

#include <map>
#include <memory>
#include <vector>

#include "backends/raster/slice_files.h"
#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Fractions come from one thread, and each slice's before it is passed.
class GreyStack : public pipeline::FractionSink {
  public:
    /// `folder`: a FolderSink, of the format that `options` have.
    GreyStack(std::unique_ptr<pipeline::SliceSink> folder, FolderOptions options)
        : folder_(std::move(folder)), options_(std::move(options)) {}

    /// Opens the folder for the slices of `info`, whose parts have the first `materials`; returns how many
    /// of its first slices an earlier run has left in it. Before `begin`, whose slices are the others.
    Result<int32_t> open(const pipeline::PrintInfo& info, int32_t materials);
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override;
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override;
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& totals) override;
    /// Writes slice z, black where nothing of it came. Called for all slices in order.
    Result<void> passed(int32_t z);

  private:
    std::unique_ptr<pipeline::SliceSink> folder_;
    FolderOptions options_;
    pipeline::PrintInfo info_;
    size_t materials_ = 0, material_ = 0;
    std::map<int32_t, std::vector<float>> planes_;
};

}  // namespace openfab::raster
