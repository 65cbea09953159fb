// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes fractions before the dither as an array for numpy: one `.npy` file of format 1.0, type
// float32, of shape (slices, rows, columns, materials), which is (z, y, x, material); index 0 is the
// lowest of each. `FILE.npy.json` beside it has the pitch, the origin and the materials. What is void
// takes no room on file systems that keep holes. Until it is whole it is `FILE.npy.part`, which goes where
// the print ends early: what was not printed would be void in it.

#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "backends/common/part_file.h"
#include "runtime/pipeline/fraction_sink.h"

namespace openfab::raster {

/// Hashes fractions of voxels, in the order of the array, from its voxel `first` on: a sum over those that
/// are not void, so that it does not matter in which order and pieces they come.
uint64_t fractions_hash(std::span<const float> fractions, size_t materials, int64_t first);

class FractionFile : public pipeline::FractionSink {
  public:
    /// Nothing is opened before begin.
    explicit FractionFile(std::string path) : path_(std::move(path)) {}

    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override;
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override;
    Result<void> status() const override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    void fail(const Error& error);

    std::string path_;
    std::unique_ptr<backends::PartFile> part_;
    backends::OutputFile* file_ = nullptr;  ///< of `part_`
    pipeline::PrintInfo info_;
    int64_t materials_ = 0;
    mutable std::mutex mutex_;  ///< for error_
    Result<void> error_;
    std::atomic<uint64_t> hash_{0};
};

}  // namespace openfab::raster
