// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slices on their way from the threads of a print to its reader, who takes them over: nothing is
// copied. The print waits while the queue is full.

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "runtime/pipeline/fraction_sink.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::python {

/// One slice; rows from the lowest y, x rises.
struct Slice {
    int32_t z = 0;
    std::vector<uint8_t> codes;    ///< [y][x]
    std::vector<float> fractions;  ///< [y][x][material]; empty where not asked for
    std::vector<float> rates;      ///< [y][x][column][material]; likewise
};

/// Gathers the fractions of the slices in flight, each in an array of its own.
class FractionPlanes : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override;
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override;
    void write_rates(int32_t z, int32_t y, int32_t first_x, std::span<const float> rates) override;
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    /// Sets how many columns of derivatives there are, before the print.
    void expect_rates(int32_t columns) { columns_ = columns; }
    int32_t rate_columns() const { return columns_; }
    /// Does take() for them.
    std::vector<float> take_rates(int32_t z);
    /// Gives away the array of a slice that is printed; zeros where all of it is void.
    std::vector<float> take(int32_t z);
    int32_t materials() const { return materials_; }

  private:
    void put(std::map<int32_t, std::vector<float>>* planes, size_t per_voxel, int32_t z, int32_t y,
             int32_t first_x, std::span<const float> values);
    std::vector<float> take(std::map<int32_t, std::vector<float>>* planes, size_t per_voxel,
                            int32_t z);

    size_t width_ = 0, height_ = 0;
    int32_t materials_ = 0;
    std::mutex mutex_;
    std::map<int32_t, std::vector<float>> planes_, rates_;
    int32_t columns_ = 0;
};

class SliceQueue : public pipeline::SliceSink {
  public:
    /// `fractions` may be null.
    explicit SliceQueue(FractionPlanes* fractions) : fractions_(fractions) {}

    /// The most slices that wait, whatever their size, for the budget of memory.
    static constexpr size_t kMostSlices = 16;

    Result<void> begin(const pipeline::PrintInfo& info) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals&) override { return {}; }

    /// Returns the next slice, or nothing where there is none after so many seconds or the queue
    /// was closed.
    std::optional<Slice> take(double seconds);
    /// Ends the wait of both sides; nothing is taken in any more.
    void close();

  private:
    FractionPlanes* fractions_;
    int32_t bits_ = 4;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Slice> slices_;
    bool closed_ = false;
};

}  // namespace openfab::python
