// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes an `.ofr` file or stream (backends/ofr/format.h).

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/common/slice_sink.h"
#include "backends/ofr/format.h"

namespace openfab::ofr {

/// Level of zstd. Measured on a dithered slice of 2362 x 827 voxels, CPU time of one core of a
/// 2-core AVX2 machine: 730 M voxels/s and 231 kB; level 3 takes a quarter longer for 3 % less,
/// level 6 six times as long for 9 % less. A slice of few runs goes at more than 2 G voxels/s, at
/// either level.
constexpr int kZstdLevel = 1;

class OfrSink : public backends::SliceSink {
  public:
    /// `path` may be `-` for standard output. A file is there from the start and holds whole slices
    /// at any time after; where the disk is full it is cut back to the last whole one.
    static Result<std::unique_ptr<backends::SliceSink>> create(const std::string& path);

    Result<void> begin(const backends::PrintInfo& info) override;
    std::vector<uint8_t> encode(const backends::SliceView& slice) const override;
    Result<void> commit(int32_t z, const std::vector<uint8_t>& bytes) override;
    Result<void> finish(const backends::PrintTotals& totals) override;

  private:
    explicit OfrSink(backends::OutputFile file) : file_(std::move(file)) {}
    /// The error, with how much of the file is of use.
    Error with_slices_kept(const Error& error) const;

    backends::OutputFile file_;
    std::vector<IndexEntry> entries_;
    bool broken_ = false;
};

}  // namespace openfab::ofr
