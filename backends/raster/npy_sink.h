// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes the codes of a print as an array for numpy, for programs that compute with voxels: one
// `.npy` file of format 1.0, type uint8, of shape (slices, rows, columns), which is (z, y, x); index
// 0 is the lowest of each. Code 0 is void, c the c-th material. `FILE.npy.json` beside it has the
// pitch, the origin and the materials.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "backends/common/output_file.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Returns the path of the text beside an array.
std::string array_json_path(const std::string& path);

/// Returns that text; `totals.complete` false marks an incomplete print. `fractions_hash`: of an array of
/// fractions (fraction_file.h).
std::string array_json(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                       int32_t slices_written, std::optional<uint64_t> fractions_hash = {});

class NpySink : public pipeline::SliceSink {
  public:
    static Result<std::unique_ptr<pipeline::SliceSink>> create(const std::string& path);

    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    /// Gives the array the shape of what was written, so that the slices of an interrupted print can
    /// be read.
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    explicit NpySink(backends::OutputFile file) : file_(std::move(file)) {}

    backends::OutputFile file_;
    pipeline::PrintInfo info_;
    int32_t written_ = 0;
    bool broken_ = false;
};

}  // namespace openfab::raster
